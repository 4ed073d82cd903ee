"""STL, by trimesh: triangles without shared vertices, which become shared again on reading."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import content_kind, read_bytes
from caricli.io.meshes.trimesh_load import trimesh_load
from caricli.io.outputs import write_bytes
from caricli.limits import MAX_FILE_BYTES, MAX_POLYGONS
from caricli.structures import Mesh

_KIND = "an STL file"
_HEADER_BYTES = 84
_TRIANGLE_BYTES = 50
_MAX_SOLIDS = 1024


def read_stl(path: str | Path) -> Mesh:
    """Read an STL file, text or binary; corners in one place become one vertex, numbered as they first come.

    Returns a Mesh of triangles, float64. Raises InputError when the file is malformed or has more than MAX_POLYGONS
    triangles, which is found out before anything else is read.
    """
    data = read_bytes(path, MAX_FILE_BYTES, _KIND)
    with naming(path):
        _check_size(data)
        corners = _corners(data)
        if corners.ndim != 2 or corners.shape[1] != 3 or not len(corners):
            raise InputError("expected a mesh with triangles, found none")
        # Adding zero makes minus zero the same place as zero.
        places, first, place = np.unique(corners + 0.0, axis=0, return_index=True, return_inverse=True)
        order = np.argsort(first)
        number = np.empty(len(order), np.int64)
        number[order] = np.arange(len(order))
        return Mesh(places[order], number[place.ravel()].reshape(-1, 3))


def write_stl(path: str | Path, mesh: Mesh) -> None:
    """Write a binary STL: triangles in single precision, no UVs.

    Raises OutputError when the file cannot be written.
    """
    import trimesh
    from trimesh.exchange.stl import export_stl

    write_bytes(path, export_stl(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)))


def _check_size(data: bytes) -> None:
    """Refuse what is neither the binary nor the text form, and more triangles than the cap."""
    count = int.from_bytes(data[_HEADER_BYTES - 4 : _HEADER_BYTES], "little")
    if len(data) != _HEADER_BYTES + _TRIANGLE_BYTES * count:
        kind = content_kind(data)
        text = data.lower()
        if kind or not text.lstrip().startswith(b"solid"):
            raise InputError(f"expected {_KIND}, found {kind or 'something else'} or a truncated one")
        # These words are what trimesh splits the text at.
        count = max(text.count(b"vertex") // 3, text.count(b"normal"))
        if text.count(b"endsolid") > _MAX_SOLIDS:
            raise InputError(f"expected at most {_MAX_SOLIDS} solids, found more")
    if count > MAX_POLYGONS:
        raise InputError(f"expected at most {MAX_POLYGONS} triangles, found {count}")


def _corners(data: bytes) -> np.ndarray:
    """The corners (3F, 3) of all triangles in their order."""
    from trimesh.exchange.stl import load_stl

    try:
        with np.errstate(invalid="ignore"):  # of what is no number, which a Mesh refuses
            solid = trimesh_load(load_stl, data)
            solids = [solid] if "vertices" in solid else [*solid["geometry"].values()]
            return np.concatenate([np.asarray(part["vertices"], np.float64) for part in solids] or [np.zeros((0, 3))])
    except Exception as error:  # trimesh raises whatever it meets
        raise InputError(f"expected {_KIND}, found a damaged one: {shown(error, 120)}") from error
