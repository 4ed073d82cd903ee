"""What all readers share: bytes under a cap, text that is safe to print, and a word for rubbish."""

import codecs
import io
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from caricli.errors import InputError, shown

_SIGNATURES = (
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"GIF8", "a GIF image"),
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "a zip archive"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"\x93NUMPY", "an NPY array"),
    (b"glTF", "a GLB file"),
)


def content_kind(data: bytes) -> str | None:
    """Name what bytes look like when they are not the text that was expected; the start of a file is enough.

    Returns a phrase such as "an HTML page", or None when they may be plain text.
    """
    head = bytes(data[:4096])
    if is_usd(head):
        return "USD, which caricli writes and does not read"
    for signature, kind in _SIGNATURES:
        if head.startswith(signature):
            return kind
    if looks_like_pickle(head):
        return "a pickle"
    start = text_start(head)[:16].lower()
    if start.startswith((b"<!doctype", b"<html", b"<head", b"<?xml", b"<svg")):
        return "an HTML or XML page"
    return "binary data" if b"\0" in head else None


def text_start(data: bytes) -> bytes:
    """Bytes from the first that says something: without a byte-order mark and blanks before it."""
    return data.lstrip(b"\xef\xbb\xbf \t\r\n")


def is_usd(data: bytes) -> bool:
    """Whether bytes begin a file of USD: a layer, or a USDZ, which is a zip archive whose first file is one."""
    if data.startswith((b"PXR-USDC", b"#usda ")):
        return True
    first = data[30 : 30 + int.from_bytes(data[26:28], "little")].lower()
    return data.startswith(b"PK\x03\x04") and first.endswith((b".usd", b".usda", b".usdc"))


def column_separator(header: str) -> str:
    """What stands between the columns of a CSV, by its first line: a comma, or a semicolon where that has no comma."""
    return ";" if ";" in header and "," not in header else ","


def without_utf16(data: bytes) -> bytes:
    """Text in UTF-16 with its byte-order mark, as spreadsheets save it, in UTF-8; any other bytes as they are."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", "replace").encode()
    return data


def looks_like_pickle(data: bytes) -> bool:
    """Whether bytes start as a pickle of protocol 2 to 5 does."""
    return len(data) > 2 and data[0] == 0x80 and 2 <= data[1] <= 5


@contextmanager
def opened(path: str | Path, kind: str) -> Iterator[io.BufferedReader]:
    """Open a regular file to read its bytes; all that caricli reads goes through here.

    kind: what is expected, for the message ("an OBJ file").
    Raises InputError when the path is missing, no regular file, empty or unreadable, also where reading it fails.
    """
    try:
        # Looking before opening: opening a pipe would wait for a writer for ever.
        mode = os.stat(path).st_mode
        if not stat.S_ISREG(mode):
            other = "a folder" if stat.S_ISDIR(mode) else "something that is not a regular file"
            raise InputError(f"{shown(path)}: expected {kind}, found {other}")
        with open(path, "rb") as stream:
            if not os.fstat(stream.fileno()).st_size:
                raise InputError(f"{shown(path)}: expected {kind}, found an empty file")
            yield stream
    except FileNotFoundError:
        raise InputError(f"{shown(path)}: expected {kind}, found no such file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{shown(path)}: expected {kind}, but it cannot be read: {shown(reason)}") from error


def read_bytes(path: str | Path, max_bytes: int, kind: str) -> bytes:
    """Read a regular file whole.

    max_bytes: the largest size accepted. kind: what is expected, for the message ("an OBJ file").
    Returns at least one byte.
    Raises InputError when the path is missing, no regular file, unreadable, empty or too large.
    """
    with opened(path, kind) as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > max_bytes:
            raise InputError(f"{shown(path)}: expected {kind} of at most {max_bytes} bytes, found {size} bytes")
        # read(n) allocates n bytes at once, so n is what is there and not the cap.
        return stream.read(size)


def read_start(path: str | Path, count: int, kind: str) -> bytes:
    """Read the first bytes of a regular file, ``count`` at most, as `read_bytes` does."""
    with opened(path, kind) as stream:
        return stream.read(count)


def read_text(path: str | Path, max_bytes: int, kind: str) -> str:
    """Read a UTF-8 text file whole, as `read_bytes` does; binary data, HTML and invalid UTF-8 are refused too."""
    return decode_text(read_bytes(path, max_bytes, kind), path, kind)


def decode_text(data: bytes, name: object, kind: str) -> str:
    """Turn bytes into text, strictly UTF-8, without the byte-order mark that some programs write first.

    name: the file, for the message. kind: what is expected.
    Raises InputError for binary data, HTML or invalid UTF-8.
    """
    other = content_kind(data)
    if other:
        raise InputError(f"{shown(name)}: expected {kind}, found {other}")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{shown(name)}: expected {kind} in UTF-8, found an invalid byte at {error.start}") from None


def is_utf8(name: str) -> bool:
    """Whether the name of a file is text that can be written into another one: the file system takes any bytes."""
    try:
        name.encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True
