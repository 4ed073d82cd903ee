"""What rigs are made from: a neutral face and the pictures on it."""

from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np

from caricli.errors import naming
from caricli.io.face import read_face, read_picture_names
from caricli.io.gltf.format import SUFFIXES
from caricli.io.gltf.read_gltf import read_gltf, read_gltf_mesh
from caricli.io.image import read_image
from caricli.io.meshes.mtl import material_pictures
from caricli.io.meshes.obj import read_painted_obj
from caricli.io.npz import read_npz, text_of
from caricli.io.rig import SCHEMA as RIG_SCHEMA
from caricli.io.rig import read_rig
from caricli.io.worn import PictureNames
from caricli.structures import Face, Material, Pictures, Rig
from caricli.structures.materials import material_named
from caricli.structures.pictures import PICTURED

EYES_FILE = "eyes.png"
"""Name of the picture of the eyes beside that of the skin."""

BUST_FILE = "bust.png"
"""That of the bust."""


def load_rig(path: Path) -> Rig:
    """The Rig of an NPZ, or of a GLB or glTF, ours or another program's. Raises InputError."""
    return read_gltf(path) if path.suffix.lower() in SUFFIXES else read_rig(path)


@dataclass(frozen=True)
class PictureSources:
    """Where the pictures on a face are. skin, eyes, hair, bust: paths, or None."""

    skin: Path | None = None
    eyes: Path | None = None
    hair: Path | None = None
    bust: Path | None = None

    @property
    def files(self) -> list[Path]:
        """Those that there are."""
        return [path for path in astuple(self) if path is not None]

    def load(self) -> Pictures:
        """Read them."""
        return Pictures(*(None if path is None else read_image(path) for path in astuple(self)))


def picture_sources(face: Path, texture: Path | None = None) -> PictureSources:
    """The pictures on a face: what the NPZ names, or the OBJ, itself or beside the NPZ; and of the eyes what they name,
    or the `eyes.png` beside the skin's, as of the bust `bust.png`. In an OBJ the skin is what has no name of another
    Material, and of several pictures the one on most polygons.

    face: path of an OBJ or NPZ; other files name none beside them. texture: path of a picture of the skin in the place
    of its own, or None; it brings the eyes and the bust that are beside it, and a bust in the colours of another skin
    is left.
    """
    own = _own_sources(face)
    if texture is None:
        return own
    eyes = _beside(texture, EYES_FILE)
    return replace(own, skin=texture, eyes=eyes or own.eyes, bust=_beside(texture, BUST_FILE))


def _own_sources(face: Path) -> PictureSources:
    suffix = face.suffix.lower()
    if suffix not in (".obj", ".npz"):
        return PictureSources()
    if suffix == ".npz" and face.is_file():
        names = read_picture_names(face)
        if names != PictureNames():
            return PictureSources(*(None if name is None else face.with_name(name) for name in names))
    mesh = face.with_suffix(".obj") if suffix == ".npz" else face
    named = material_pictures(mesh) if mesh.is_file() else {}
    kinds = ((PICTURED.get(material_named(name)), path) for name, path in reversed(named.items()))
    sources = PictureSources(**{kind: path for kind, path in kinds if kind is not None})
    skin = sources.skin
    if skin is None:
        return sources
    bust = sources.bust or _beside(skin, BUST_FILE)
    return replace(sources, eyes=sources.eyes or _beside(skin, EYES_FILE), bust=bust)


def _beside(path: Path, name: str) -> Path | None:
    """The file of a name beside another, where there is one."""
    other = path.with_name(name)
    return other if other.is_file() else None


def load_shown_face(path: Path) -> Face:
    """What there is to see of a file: a face or a mesh with the pictures that it wears, or the neutral face of a rig.

    path: NPZ of either, or any mesh. Raises InputError.
    """
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:
        return _gltf_face(path)
    if suffix == ".npz" and text_of(read_npz(path).get("schema")) == RIG_SCHEMA:
        return read_rig(path).face
    face = _obj_face(path) if suffix == ".obj" else read_face(path)
    if face.mesh.uvs is None or face.pictures:
        return face
    with naming(path):
        return replace(face, pictures=picture_sources(path).load())


def _obj_face(path: Path) -> Face:
    """The mesh of an OBJ and what its polygons are of."""
    mesh, names = read_painted_obj(path)
    kinds = {name: material_named(name) for name in set(names)}
    materials = np.array([kinds[name] for name in names], np.int32)
    return Face(mesh, materials=materials if materials.any() else None)


def _gltf_face(path: Path) -> Face:
    """The rig or the one painted mesh of a glTF file, else all that is in the scene, which wears nothing."""
    rig = read_gltf(path)
    if rig.names or Material.EYE in rig.triangle_materials:
        return rig.face
    scene = read_gltf_mesh(path)
    worn = rig.pictures or rig.materials is not None
    if worn and rig.mesh.topology_id == scene.topology_id and rig.mesh.same_layout(scene):
        return replace(rig.face, mesh=scene)
    return Face(scene)


def load_pictures(face: Path, texture: Path | None = None) -> Pictures:
    """What is on a face: as ``picture_sources`` has it, or in a GLB or glTF that is one painted mesh.

    face: path of any. texture: path of a picture of the skin in the place of its own, or None.
    """
    if face.suffix.lower() not in SUFFIXES:
        return picture_sources(face, texture).load()
    own = _gltf_face(face).pictures
    return own if texture is None else replace(own, skin=read_image(texture), bust=None)
