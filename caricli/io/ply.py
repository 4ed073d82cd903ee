"""PLY, by trimesh: vertex order and count are kept."""

import io
import warnings
from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import content_kind, read_bytes
from caricli.io.outputs import write_bytes
from caricli.limits import MAX_CORNERS, MAX_FILE_BYTES, MAX_POLYGONS, MAX_VERTICES
from caricli.structures import Mesh

_KIND = "a PLY file"
_MAX_HEADER_BYTES = 2**16
_MAX_PROPERTIES = 256
_MOST = {"vertex": MAX_VERTICES, "face": MAX_POLYGONS}


def read_ply(path: Path) -> Mesh:
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
        return Mesh(np.asarray(elements["vertices"], np.float64), elements["faces"])


def write_ply(path: Path, mesh: Mesh) -> None:
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
    header, marker, _ = data[:_MAX_HEADER_BYTES].partition(b"end_header")
    if not marker:
        raise InputError(f"expected {_KIND} with a header of at most {_MAX_HEADER_BYTES} bytes, found none")
    lines = [line.split() for line in header.splitlines()]
    if sum(words[:1] == [b"property"] for words in lines) > _MAX_PROPERTIES:
        raise InputError(f"expected at most {_MAX_PROPERTIES} properties, found more")
    rows = 0
    for words in lines:
        if words[:1] == [b"element"]:
            rows += _element_count(words)
    if [b"format", b"ascii"] in [words[:2] for words in lines]:
        # Every line of a text becomes an array, and lines that are not there would only be left out.
        line_count = data[len(header) :].strip().count(b"\n")
        if line_count != rows:
            raise InputError(f"expected {rows} lines of values, found {line_count}")


def _element_count(words: list[bytes]) -> int:
    """How many rows a line of the header, such as ``element vertex 8``, claims."""
    name = words[1].decode("latin-1") if len(words) == 3 else ""
    if not name or not words[2].isdigit() or len(words[2]) > 18:
        raise InputError(f"expected 'element NAME COUNT' in the header, found {shown(b' '.join(words), 60)!r}")
    if name == "edge":
        raise InputError("expected vertices and faces only, found edges")
    most = _MOST.get(name, MAX_CORNERS)
    if int(words[2]) > most:
        raise InputError(f"expected at most {most} of {shown(name, 40)}, found {int(words[2])}")
    return int(words[2])


def _load(data: bytes) -> dict:
    from trimesh.exchange.ply import load_ply

    try:
        with warnings.catch_warnings():
            # NumPy's reader of text only warns of words that are no numbers.
            warnings.simplefilter("error", DeprecationWarning)
            return load_ply(io.BytesIO(data), fix_texture=False, skip_materials=True)
    except Exception as error:  # trimesh raises whatever it meets
        reason = "damaged, or binary with polygons of different sizes"
        raise InputError(f"expected {_KIND}, found one that is {reason}: {shown(error, 120)}") from error
