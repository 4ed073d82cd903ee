"""What rigs are made from: a neutral face and the pictures on it."""

from dataclasses import dataclass
from pathlib import Path

from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image
from caricli.io.mtl import texture_path
from caricli.io.rig import read_rig
from caricli.methods.rig.make_rig import Pictures
from caricli.structures import Rig

EYES_FILE = "eyes.png"
"""Name of the picture of the eyes beside that of the skin."""


def load_rig(path: Path) -> Rig:
    """The Rig of an NPZ, or of a GLB, ours or another program's. Raises InputError."""
    return read_gltf(path) if path.suffix.lower() == ".glb" else read_rig(path)


@dataclass(frozen=True)
class PicturePaths:
    """Where the pictures on a face are. skin, eyes: paths, or None."""

    skin: Path | None = None
    eyes: Path | None = None

    @property
    def files(self) -> list[Path]:
        """Those that there are."""
        return [path for path in (self.skin, self.eyes) if path is not None]

    def load(self) -> Pictures:
        """Read them."""
        return Pictures(*(None if path is None else read_image(path) for path in (self.skin, self.eyes)))


def picture_paths(face: Path, texture: Path | None = None) -> PicturePaths:
    """The pictures on a face: the given one, else what the OBJ names, or the OBJ beside an NPZ; and the `eyes.png` that
    `caricli texture` wrote beside that.

    face: path of an OBJ or NPZ. texture: path of the skin's picture, or None to look for it.
    """
    mesh = face if face.suffix.lower() == ".obj" else face.with_suffix(".obj")
    skin = texture_path(mesh) if texture is None and mesh.is_file() else texture
    if skin is None:
        return PicturePaths()
    eyes = skin.with_name(EYES_FILE)
    return PicturePaths(skin, eyes if eyes.is_file() else None)
