"""Meshes in any of the formats that are read and written; the name of a file says which."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, OutputError, shown
from caricli.io.gltf.read_gltf import read_gltf_mesh
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import read_image
from caricli.io.obj import read_obj, write_obj
from caricli.io.ply import read_ply, write_ply
from caricli.io.stl import read_stl, write_stl
from caricli.structures import Mesh, Rig

_READERS = {
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": read_stl,
    ".glb": read_gltf_mesh,
    ".gltf": read_gltf_mesh,
}
MESH_SUFFIXES = tuple(_READERS)
"""Ends of names, in small letters, of the formats of meshes."""

_GLTF = (".glb", ".gltf")


def is_mesh_file(path: str | Path) -> bool:
    """Whether the name of a file is that of a mesh, as ``read_mesh`` reads it."""
    return Path(path).suffix.lower() in MESH_SUFFIXES


def mesh_files(folder: str | Path) -> list[Path]:
    """The meshes of a folder by name: its OBJ files, or where there are none, those of the first other format there is.

    Raises InputError when it is no folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{shown(folder)}: expected a folder of OBJ files or other meshes, found none")
    files = sorted(folder.iterdir())
    by_suffix = ([path for path in files if path.suffix.lower() == suffix] for suffix in MESH_SUFFIXES)
    return next(filter(None, by_suffix), [])


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh: OBJ, PLY, STL, GLB or glTF, told apart by the suffix; no other file is opened.

    Vertices keep their order and number, but in STL, which does not share them between triangles. Of a GLB that is a
    rig it is the neutral mesh.
    Returns a Mesh, float64. Raises InputError when the suffix is another or the file is malformed, has no mesh, is
    beyond the caps or leads to other files.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise InputError(f"{shown(path)}: expected a mesh ({_any_suffix()}), found {shown(suffix, 20)!r}")
    return _READERS[suffix](path)


def write_mesh(path: str | Path, mesh: Mesh, texture: str | None = None, mtl: Path | None = None) -> None:
    """Write a mesh in the format of the suffix; OBJ keeps polygons and UVs, glTF triangles and UVs, the others neither.

    texture: the file name of a PNG in the same folder: an OBJ names it, GLB and glTF embed it, so it must be there.
    mtl: path of the material file of an OBJ.
    Raises OutputError when the suffix is another, the format has no place for the texture, or it cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".obj":
        write_obj(path, mesh, texture, mtl)
    elif suffix in _GLTF:
        _write_still_gltf(path, mesh, texture)
    elif texture is not None:
        raise OutputError(f"{shown(path)}: expected .obj, .glb or .gltf for a mesh with a texture, found {suffix!r}")
    elif suffix == ".ply":
        write_ply(path, mesh)
    elif suffix == ".stl":
        write_stl(path, mesh)
    else:
        raise OutputError(f"{shown(path)}: expected a mesh ({_any_suffix()}), found {shown(suffix, 20)!r}")


def _write_still_gltf(path: Path, mesh: Mesh, texture: str | None) -> None:
    if texture is not None and mesh.uvs is None:
        raise OutputError(f"{shown(path)}: expected a mesh with UVs for the texture, found none")
    picture = None if texture is None else read_image(path.parent / texture)
    no_shapes = np.zeros((0, len(mesh.vertices), 3), np.float32)
    write_gltf(path, Rig((), mesh, no_shapes, texture=picture))


def _any_suffix() -> str:
    return ", ".join(MESH_SUFFIXES[:-1]) + " or " + MESH_SUFFIXES[-1]
