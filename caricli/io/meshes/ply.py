"""PLY, by trimesh: vertex order and count are kept."""

import io
from itertools import islice, pairwise
from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import content_kind, read_bytes
from caricli.io.meshes.trimesh_load import trimesh_load
from caricli.io.outputs import write_bytes
from caricli.limits import MAX_FILE_BYTES, MAX_POLYGONS, MAX_VERTICES
from caricli.structures import Mesh

_KIND = "a PLY file"
_MAX_HEADER_BYTES = 2**16
_MAX_PROPERTIES = 256
_MAX_EMPTY_LINES = 16
_KEYWORDS = (b"format", b"comment", b"obj_info", b"element", b"property")
_CORNERS = (b"vertex_indices", b"vertex_index")
_FORMS = ([b"ascii"], [b"binary_little_endian"], [b"binary_big_endian"])


def read_ply(path: str | Path) -> Mesh:
    """Read the vertices and polygons of a PLY file, text or binary; colours, normals and UVs are left aside.

    In a binary file all polygons must have the same number of corners; mixed ones of a text file become triangles.
    Returns a Mesh, float64. Raises InputError when the file is malformed, holds edges or claims more than the caps,
    which is found out from its header before anything else is read.
    """
    data = read_bytes(path, MAX_FILE_BYTES, _KIND)
    with naming(path):
        _check_header(data)
        elements = _load(data)
        if "faces" not in elements or "vertices" not in elements:
            raise InputError("expected a mesh with vertices and faces, found none")
        return Mesh(elements["vertices"], elements["faces"])


def write_ply(path: str | Path, mesh: Mesh) -> None:
    """Write a binary PLY: vertices in single precision, polygons as triangles, no UVs.

    Raises OutputError when the file cannot be written.
    """
    import trimesh
    from trimesh.exchange.ply import export_ply

    triangles = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    write_bytes(path, export_ply(triangles, vertex_normal=False, include_attributes=False))


def _check_header(data: bytes) -> None:
    """Refuse what a header claims beyond the caps, before memory is asked for by it."""
    if data[:4] not in (b"ply\n", b"ply\r"):
        raise InputError(f"expected {_KIND}, found {content_kind(data) or 'something else'}")
    head = data[:_MAX_HEADER_BYTES]
    lines = [line.split() for line in head.split(b"\n")]
    if [b"end_header"] not in lines:
        raise InputError(f"expected {_KIND} with a header of at most {_MAX_HEADER_BYTES} bytes, found none")
    lines = lines[: lines.index([b"end_header"])]
    # Only what trimesh takes for the same thing: a line that it alone read as an element could claim anything.
    odd = next((words for words in lines[1:] if not words or words[0] not in _KEYWORDS), None)
    if odd is not None:
        raise InputError(f"expected a line of a PLY header, found {shown(b' '.join(odd), 60)!r}")
    if len(lines) < 2 or lines[1][:1] != [b"format"] or lines[1][1:2] not in _FORMS:
        raise InputError("expected 'format ascii 1.0' or a binary format in line 2, found none")
    if sum(words[0] == b"property" for words in lines) > _MAX_PROPERTIES:
        raise InputError(f"expected at most {_MAX_PROPERTIES} properties, found more")
    rows = sum(_element_count(words) for words in lines if words[0] == b"element")
    if rows > MAX_VERTICES + MAX_POLYGONS:
        raise InputError(f"expected at most {MAX_VERTICES + MAX_POLYGONS} rows, found {rows}")
    if lines[1][1] == b"ascii":
        _check_line_count(data, rows, len(lines) + 1)
        _check_rows(data, lines)


def _check_line_count(data: bytes, rows: int, header_lines: int) -> None:
    # Every line of a text becomes an array, and lines that are not there would only be left out.
    line_count = data.count(b"\n") + (not data.endswith(b"\n")) - header_lines
    if not rows <= line_count <= rows + _MAX_EMPTY_LINES:
        raise InputError(f"expected {rows} lines of values, found {line_count}")


def _check_rows(data: bytes, header: list[list[bytes]]) -> None:
    """Refuse rows of a text with other values than its header claims: trimesh leaves them out, or cuts them."""
    lines = islice(io.BytesIO(data), len(header) + 1, None)
    rows = filter(None, map(bytes.split, lines))
    starts = [number for number, words in enumerate(header) if words[0] == b"element"]
    for start, end in pairwise([*starts, len(header)]):
        properties = [words[1:] for words in header[start + 1 : end] if words[0] == b"property"]
        for row in islice(rows, int(header[start][2])):
            if not _has(row, properties):
                values = shown(b" ".join(row), 60)
                raise InputError(f"expected {_KIND}, found a damaged one, with a row of other values: {values!r}")


def _has(row: list[bytes], properties: list[list[bytes]]) -> bool:
    """Whether a row has as many words as its properties ask for, and whole numbers for corners."""
    at = 0
    try:
        for kind, *_, name in properties:
            count = int(row[at]) if kind == b"list" else 0
            corners = row[at + 1 : at + 1 + count] if name in _CORNERS else ()
            if not all(word.removeprefix(b"-").isdigit() for word in corners):
                return False
            at += 1 + count
    except (ValueError, IndexError):
        return False
    return at == len(row)


def _element_count(words: list[bytes]) -> int:
    """How many rows a line of the header, such as ``element vertex 8``, claims."""
    name = words[1].decode("latin-1") if len(words) == 3 else ""
    if not name or not words[2].isdigit() or len(words[2]) > 18:
        raise InputError(f"expected 'element NAME COUNT' in the header, found {shown(b' '.join(words), 60)!r}")
    if name == "edge":
        raise InputError("expected vertices and faces only, found edges")
    count = int(words[2])
    most = MAX_VERTICES if name == "vertex" else MAX_POLYGONS
    if count > most:
        raise InputError(f"expected at most {most} of {shown(name, 40)}, found {count}")
    return count


def _load(data: bytes) -> dict:
    from trimesh.exchange.ply import load_ply

    try:
        with np.errstate(invalid="ignore"):  # of what is no number, which a Mesh refuses
            elements = trimesh_load(load_ply, data, fix_texture=False, skip_materials=True)
            # Lines of a text may have different lengths.
            return {key: np.asarray(rows, np.float64) if key == "vertices" else rows for key, rows in elements.items()}
    except Exception as error:  # trimesh raises whatever it meets
        reason = "damaged, or binary with polygons of different sizes (then save it as text or as triangles)"
        raise InputError(f"expected {_KIND}, found one that is {reason}: {shown(error, 120)}") from error
