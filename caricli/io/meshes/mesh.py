"""Meshes in any of the formats that are read and written; the name of a file says which."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from caricli.errors import InputError, OutputError, shown
from caricli.io.gltf.read_gltf import read_gltf_mesh
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import read_image
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.meshes.ply import read_ply, write_ply
from caricli.io.meshes.stl import read_stl, write_stl
from caricli.structures import Mesh, Pictures, Rig
from caricli.structures.materials import Finish


@dataclass(frozen=True)
class _Format:
    """How a format is read and written.

    write: takes a path and a mesh, and where the format has a place for a picture, what else ``write_mesh`` takes.
    """

    read: Callable[[str | Path], Mesh]
    write: Callable[..., None]
    keeps_texture: bool = False


def _write_still_gltf(
    path: Path,
    mesh: Mesh,
    texture: str | None,
    _mtl: Path | None,
    others: Mapping[str, str | Finish | None] | None,
    materials: np.ndarray | None,
) -> None:
    if texture is not None and mesh.uvs is None:
        raise OutputError(f"{shown(path)}: expected a mesh with UVs for the texture, found none")
    # No polygon shows a picture of eyes where all are skin.
    names = {"skin": texture, **(others if others and materials is not None else {})}
    pictures = Pictures(**{key: read_image(path.parent / name) for key, name in names.items() if isinstance(name, str)})
    no_shapes = np.zeros((0, len(mesh.vertices), 3), np.float32)
    write_gltf(path, Rig((), mesh, no_shapes, materials, pictures))


_GLTF = _Format(read_gltf_mesh, _write_still_gltf, keeps_texture=True)
_FORMATS = {
    ".obj": _Format(read_obj, write_obj, keeps_texture=True),
    ".ply": _Format(read_ply, write_ply),
    ".stl": _Format(read_stl, write_stl),
    ".glb": _GLTF,
    ".gltf": _GLTF,
}
MESH_SUFFIXES = tuple(_FORMATS)
"""Ends of names, in small letters, of the formats of meshes."""


def _listed(suffixes: Sequence[str]) -> str:
    return ", ".join(suffixes[:-1]) + " or " + suffixes[-1]


ANY_MESH = f"a mesh ({_listed(MESH_SUFFIXES)})"
"""What is expected where any of them will do, for messages."""


def keeps_texture(path: str | Path) -> bool:
    """Whether the format of a mesh file has a place for a picture."""
    return _FORMATS[Path(path).suffix.lower()].keeps_texture


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
    """Read a mesh of one of MESH_SUFFIXES, which says the format; no other file is opened.

    Vertices keep their order and number, but in STL, which does not share them between triangles. Of a GLB that is a
    rig it is the neutral mesh.
    Returns a Mesh, float64. Raises InputError when the suffix is another or the file is malformed, has no mesh, is
    beyond the caps or leads to other files.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise InputError(f"{shown(path)}: expected {ANY_MESH}, found {shown(suffix, 20)!r}")
    return _FORMATS[suffix].read(path)


def write_mesh(
    path: str | Path,
    mesh: Mesh,
    texture: str | None = None,
    mtl: Path | None = None,
    others: Mapping[str, str | Finish | None] | None = None,
    materials: np.ndarray | None = None,
) -> None:
    """Write a mesh in the format of the suffix; OBJ keeps polygons and UVs, glTF triangles and UVs, the others neither.

    texture, others: the file names of PNGs in the same folder, as of ``write_obj``, which names them; GLB and glTF
    embed them, so they must be there. mtl: path of the material file of an OBJ. materials: (P,) Material of polygons.
    Raises OutputError when the suffix is another, the format has no place for the texture, or it cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise OutputError(f"{shown(path)}: expected {ANY_MESH}, found {shown(suffix, 20)!r}")
    chosen = _FORMATS[suffix]
    if chosen.keeps_texture:
        chosen.write(path, mesh, texture, mtl, others, materials)
    elif texture is None and not any(isinstance(own, str) for own in (others or {}).values()):
        chosen.write(path, mesh)
    else:
        textured = _listed([name for name, other in _FORMATS.items() if other.keeps_texture])
        raise OutputError(f"{shown(path)}: expected {textured} for a mesh with a texture, found {suffix!r}")
