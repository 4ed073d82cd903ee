"""NPZ and NPY without pickle: every header is checked against the bytes there are before anything is allocated."""

import io
import math
import re
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Literal

import numpy as np

from caricli.errors import InputError, OutputError, naming, shown
from caricli.io.files import content_kind, is_usd, looks_like_pickle, read_bytes
from caricli.io.outputs import writing
from caricli.limits import MAX_ARRAY_DIMENSIONS, MAX_NPZ_BYTES, MAX_NPZ_HEADER_BYTES, MAX_NPZ_MEMBERS

_HEADER = re.compile(
    rb"\{'descr': ?'([<>|=]?(?:b1|[iu][1248]|f[248]|[SU]\d{1,6}))', ?'fortran_order': ?(True|False), ?"
    rb"'shape': ?\(([\d, ]*)\),? ?\}\s*"
)
# Deflate cannot expand further than this, so a member that claims more is lying.
_MAX_EXPANSION = 1032
_CHUNK_BYTES = 2**20
_FILLED = 0.9
"""Of the largest file: the rest is for its headers, and for what is small."""


def read_npz(path: str | Path, max_bytes: int = MAX_NPZ_BYTES) -> dict[str, np.ndarray]:
    """Read an NPZ file.

    max_bytes: the cap on the file and on the sum of its expanded members.
    Returns arrays by name in the file's order, of native byte order: bool, int, float and text only.
    Raises InputError when it is no NPZ, holds objects, or a member's header does not match its bytes.
    """
    data = read_bytes(path, max_bytes, "an NPZ file")
    _check_directory(data, path)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            _check_members(members, path, max_bytes)
            return {_key(member): _read_member(archive, member, path) for member in members}
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, ValueError, RuntimeError) as error:
        raise InputError(f"{shown(path)}: expected an NPZ file, found a damaged one: {shown(error, 120)}") from error


def npz_holds(size: int) -> int:
    """How many things of a size in bytes one NPZ file can hold."""
    return int(_FILLED * MAX_NPZ_BYTES) // size


def write_npz(path: str | Path, arrays: Mapping[str, np.ndarray], packed: bool = True) -> None:
    """Write an NPZ file; the same arrays give the same bytes.

    arrays: bool, int, float or text by name; their order is kept. packed: compressed, or as they are,
    to be read sooner.
    Raises OutputError when it cannot be written, is more than `read_npz` takes or holds codes that are no characters,
    as names of files do that are not UTF-8; TypeError for another kind of array.
    """
    total = sum(np.asarray(value).nbytes for value in arrays.values())
    if total > MAX_NPZ_BYTES * 0.99:
        raise OutputError(f"{shown(path)}: expected at most {MAX_NPZ_BYTES} bytes of arrays, found {total}")
    for name, array in arrays.items():
        if not _is_text(np.asarray(array)):
            raise OutputError(f"{shown(path)}: {shown(name)}: expected text, found codes that are no characters")
    with writing(path), zipfile.ZipFile(path, "w") as archive:
        for name, array in arrays.items():
            value = np.asarray(array)
            if value.dtype.kind not in "biufSU":
                raise TypeError(f"{name}: arrays of {value.dtype} are not written")
            # Fixed time, system and mode: nothing of the moment or the machine enters the bytes.
            info = zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED
            info.create_system = 3
            info.external_attr = 0o644 << 16
            with archive.open(info, "w") as member:
                np.lib.format.write_array(member, value, version=(1, 0), allow_pickle=False)


def read_array(stream: IO[bytes], size: int, name: str) -> np.ndarray:
    """Read one NPY array from a stream.

    stream: positioned at the start. size: the bytes that it holds. name: the file, for the message.
    Returns an array that can be written to, of native byte order.
    Raises InputError when the header is not a plain array's or does not match the size.
    """
    with naming(name):
        dtype, shape, order, header_size = _read_header(stream)
        expected = math.prod(shape) * dtype.itemsize
        if expected != size - header_size or dtype.itemsize == 0:
            raise InputError(f"expected {expected} bytes for shape {shape} of {dtype}, found {size - header_size}")
        buffer = _read_exactly(stream, expected)
        if dtype.kind == "b" and (buffer > 1).any():
            raise InputError("expected true or false, found another value")
        array = buffer.view(dtype).reshape(shape, order=order)
        array = array.astype(dtype.newbyteorder("="), copy=False)
        if dtype.kind == "f":
            array[np.isnan(array)] = np.nan  # those that signal would warn wherever they are computed with
        if not _is_text(array):
            raise InputError("expected text, found codes that are no characters")
        return array


def _is_text(array: np.ndarray) -> bool:
    """Whether an array, where it is of text, holds characters alone: halves of a surrogate pair are none."""
    if array.dtype.kind != "U" or array.dtype.itemsize == 0:
        return True
    codes = np.ascontiguousarray(array, array.dtype.newbyteorder("=")).reshape(-1).view(np.uint32)
    return not ((codes > 0x10FFFF) | ((codes >= 0xD800) & (codes < 0xE000))).any()


def _read_header(stream: IO[bytes]) -> tuple[np.dtype, tuple[int, ...], Literal["C", "F"], int]:
    """Type, shape and order of an NPY array, and how many bytes stand before its values."""
    start = stream.read(8)
    if start[:6] != b"\x93NUMPY" or start[6:] not in (b"\1\0", b"\2\0", b"\3\0"):
        other = "a pickle" if looks_like_pickle(start) else "something else"
        raise InputError(f"expected an NPY array, found {other}")
    width = 2 if start[6] == 1 else 4
    length = int.from_bytes(stream.read(width), "little")
    if length > MAX_NPZ_HEADER_BYTES:
        raise InputError(f"expected a header of at most {MAX_NPZ_HEADER_BYTES} bytes, found {length}")
    header = stream.read(length)
    match = _HEADER.fullmatch(header)
    if not match:
        if re.search(rb"'descr': ?'\|?O", header):
            raise InputError("expected numbers or text, found Python objects, which are never loaded")
        raise InputError(f"expected an array of numbers or text, found the header {shown(header, 80)!r}")
    sides = [word.strip() for word in match[3].decode().split(",") if word.strip()]
    if len(sides) > MAX_ARRAY_DIMENSIONS or any(len(side) > 10 or not side.isdigit() for side in sides):
        raise InputError(f"expected at most {MAX_ARRAY_DIMENSIONS} dimensions, found {shown(match[3], 80)}")
    shape = tuple(int(side) for side in sides)
    return np.dtype(match[1].decode()), shape, "F" if match[2] == b"True" else "C", 8 + width + length


def _read_exactly(stream: IO[bytes], size: int) -> np.ndarray:
    """As many bytes (size,) uint8 as a stream must hold to its end."""
    buffer = np.empty(size, np.uint8)
    # One byte more than the rest is asked for, so that a zip member is read to its end and its checksum compared.
    at = 0
    while chunk := stream.read(min(_CHUNK_BYTES, size - at + 1)):
        if at + len(chunk) > size:
            raise InputError(f"expected {size} bytes of data, found more")
        buffer[at : at + len(chunk)] = np.frombuffer(chunk, np.uint8)
        at += len(chunk)
    if at < size:
        raise InputError(f"expected {size} bytes of data, found {at}")
    return buffer


def _key(member: zipfile.ZipInfo) -> str:
    return member.filename.removesuffix(".npy")


def _read_member(archive: zipfile.ZipFile, member: zipfile.ZipInfo, path: str | Path) -> np.ndarray:
    with archive.open(member) as stream:
        return read_array(stream, member.file_size, f"{shown(path)}: {shown(_key(member), 40)}")


def _check_directory(data: bytes, path: str | Path) -> None:
    """Refuse a zip directory too large to list before zipfile lists it."""
    if not data.startswith((b"PK\x03\x04", b"PK\x05\x06")) or is_usd(data):
        other = content_kind(data) or "another kind of file"
        raise InputError(f"{shown(path)}: expected an NPZ file, found {other}")
    end = data.rfind(b"PK\x05\x06")
    if end < 0 or len(data) < end + 22:
        raise InputError(f"{shown(path)}: expected an NPZ file, found a truncated one")
    size = int.from_bytes(data[end + 12 : end + 16], "little")
    # The 64-bit directory is needed by no file under the cap, and would override the size checked here.
    if data[max(end - 20, 0) : end].startswith(b"PK\x06\x07") or size > MAX_NPZ_MEMBERS * 256:
        raise InputError(f"{shown(path)}: expected at most {MAX_NPZ_MEMBERS} arrays, found a directory of {size} bytes")


def _check_members(members: list[zipfile.ZipInfo], path: str | Path, max_bytes: int) -> None:
    if not members:
        raise InputError(f"{shown(path)}: expected an NPZ file with arrays, found none")
    if len(members) > MAX_NPZ_MEMBERS:
        raise InputError(f"{shown(path)}: expected at most {MAX_NPZ_MEMBERS} arrays, found {len(members)}")
    if len({_key(member) for member in members}) < len(members):
        raise InputError(f"{shown(path)}: expected distinct names, found one twice")
    total = sum(member.file_size for member in members)
    if total > max_bytes:
        raise InputError(f"{shown(path)}: expected at most {max_bytes} bytes of arrays, found {total}")
    for member in members:
        name = f"{shown(path)}: {shown(_key(member), 40)}"
        if not member.filename.endswith(".npy"):
            raise InputError(f"{name}: expected an array, found another kind of file")
        if member.flag_bits & 1 or member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise InputError(f"{name}: expected a stored or deflated member, found another kind")
        if member.file_size > member.compress_size * _MAX_EXPANSION + 64:
            raise InputError(
                f"{name}: expected {member.file_size} bytes, found only {member.compress_size} packed ones"
            )


def text_of(array: np.ndarray | None) -> str | None:
    """The text that an array of no dimensions holds, or None where it is no such array."""
    return str(array.item()) if array is not None and array.dtype.kind == "U" and array.ndim == 0 else None


def take_array(arrays: Mapping[str, np.ndarray], key: str, kinds: str, shape: tuple[int | None, ...]) -> np.ndarray:
    """The array of a key.

    kinds: letters of the types of numbers that it may have, as NumPy's ``dtype.kind``. shape: None for any length.
    Raises InputError where there is none, or of another kind or shape.
    """
    array = arrays.get(key)
    name = shown(key, 40)
    if array is None:
        raise InputError(f"expected {name}, found none")
    fits = array.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, array.shape, strict=True))
    if array.dtype.kind not in kinds or not fits:
        expected = ",".join("*" if n is None else str(n) for n in shape)
        words = {"f": "fractions", "i": "whole numbers", "U": "text", "b": "true or false", "u": "whole numbers"}[
            kinds[0]
        ]
        raise InputError(f"{name}: expected {words} of the shape ({expected}), found {array.dtype} {array.shape}")
    return array


def take_texts(arrays: dict[str, np.ndarray], texts: Mapping[str, str], noun: str) -> None:
    """Take the texts that every file of a schema holds out of its arrays.

    arrays: changed. texts: what is expected, by key. noun: what the file is, for the message.
    Raises InputError where one is missing or another.
    """
    for key, expected in texts.items():
        text = text_of(arrays.pop(key, None))
        if text != expected:
            other = "none" if text is None else repr(shown(text, 60))
            raise InputError(f"expected {noun} with {key} {expected!r}, found {other}")
