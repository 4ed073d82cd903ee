"""GLB files and glTF texts as a document and its buffers; nothing in them is trusted, no other file is opened."""

import base64
import binascii
from pathlib import Path

from caricli.errors import InputError, OutputError, naming, shown
from caricli.io.files import content_kind, read_bytes, text_start
from caricli.io.gltf.format import BINARY_CHUNK, CHUNK, HEADER, JSON_CHUNK, MAGIC, VERSION
from caricli.io.outputs import write_bytes
from caricli.io.strict_json import format_json, parse_json
from caricli.limits import MAX_FILE_BYTES, MAX_JSON_BYTES

_DATA = "data:application/octet-stream;base64,"


def read_container(path: str | Path) -> tuple[dict, list[memoryview]]:
    """Read a GLB, or a glTF text whose buffers are inside it; the content says which.

    Returns the document and the bytes of its buffers. Raises InputError when it is malformed or names other files.
    """
    is_text = Path(path).suffix.lower() == ".gltf"
    data = read_bytes(path, MAX_FILE_BYTES, "a glTF file" if is_text else "a GLB file")
    with naming(path):
        if data[:4] != MAGIC and (is_text or text_start(data)[:1] == b"{"):
            return _from_text(data)
        return _from_chunks(data)


def write_container(path: str | Path, document: dict, binary: bytes) -> None:
    """Write a document and its one buffer as a GLB, or as one .gltf text where the path ends so.

    Raises OutputError when it is larger than what ``read_container`` takes or cannot be written.
    """
    buffer: dict[str, object] = {"byteLength": len(binary)}
    if Path(path).suffix.lower() == ".gltf":
        buffer |= {"uri": _DATA + base64.b64encode(binary).decode()}
        _write(path, format_json(document | {"buffers": [buffer]}, path, indent=None).encode(), MAX_JSON_BYTES)
        return
    text = format_json(document | {"buffers": [buffer]}, path, indent=None).strip().encode()
    text += b" " * (-len(text) % 4)
    length = HEADER.size + 2 * CHUNK.size + len(text) + len(binary)
    start = HEADER.pack(MAGIC, VERSION, length) + CHUNK.pack(len(text), JSON_CHUNK)
    _write(path, start + text + CHUNK.pack(len(binary), BINARY_CHUNK) + binary, MAX_FILE_BYTES)


def _write(path: str | Path, data: bytes, most: int) -> None:
    if len(data) > most:
        raise OutputError(f"{shown(path)}: expected at most {most} bytes of glTF, found {len(data)}")
    write_bytes(path, data)


def _from_chunks(data: bytes) -> tuple[dict, list[memoryview]]:
    """The document and the binary chunk of a GLB."""
    if data[:4] != MAGIC:
        raise InputError(f"expected a GLB file, found {content_kind(data) or 'something else'}")
    if len(data) < HEADER.size + CHUNK.size:
        raise InputError("expected a GLB file, found a truncated one")
    _, version, length = HEADER.unpack_from(data)
    if version != VERSION:
        raise InputError(f"expected glTF {VERSION}, found version {version}")
    if length != len(data):
        raise InputError(f"expected a GLB file of {length} bytes, found {len(data)}")
    chunks = _chunks(data)
    kind, text = chunks[0]
    if kind != JSON_CHUNK or len(text) > MAX_JSON_BYTES:
        raise InputError(f"expected at most {MAX_JSON_BYTES} bytes of JSON first, found another chunk")
    document = _document(bytes(text).rstrip(b" \0"))
    is_binary = len(chunks) > 1 and chunks[1][0] == BINARY_CHUNK
    return document, [chunks[1][1] if is_binary else memoryview(b"")]


def _chunks(data: bytes) -> list[tuple[bytes, memoryview]]:
    """Kind and content of the first two chunks."""
    chunks: list[tuple[bytes, memoryview]] = []
    at = HEADER.size
    while at + CHUNK.size <= len(data) and len(chunks) < 2:
        size, kind = CHUNK.unpack_from(data, at)
        at += CHUNK.size
        if size > len(data) - at:
            raise InputError(f"expected a chunk of {size} bytes, found {len(data) - at}")
        chunks.append((kind, memoryview(data)[at : at + size]))
        at += size
    return chunks


def _from_text(data: bytes) -> tuple[dict, list[memoryview]]:
    """The document of a .gltf and its buffers, which no longer have a URI."""
    if len(data) > MAX_JSON_BYTES:
        raise InputError(f"expected a glTF file of at most {MAX_JSON_BYTES} bytes, found {len(data)}")
    document = _document(data)
    buffers = document.get("buffers", [])
    if not isinstance(buffers, list) or not all(isinstance(buffer, dict) for buffer in buffers):
        raise InputError("buffers: expected a list of objects, found others")
    with naming("buffers"):
        return document, [memoryview(embedded(buffer.pop("uri", None))) for buffer in buffers]


def embedded(uri: object) -> bytes:
    """The bytes that a URI of a document holds. Raises InputError where it leads elsewhere."""
    head, marker, content = uri.partition(";base64,") if isinstance(uri, str) else ("", "", "")
    if not marker or not head.startswith("data:"):
        raise InputError(f"expected one inside the file, found another file: {shown(uri, 60)!r}")
    try:
        return base64.b64decode(content, validate=True)
    except (binascii.Error, ValueError):
        raise InputError("expected base64, found other text") from None


def _document(text: bytes) -> dict:
    document = parse_json(text, "document")
    if not isinstance(document, dict):
        raise InputError(f"expected a glTF document, found {type(document).__name__}")
    return document
