"""What a face wears, as picture files beside its own."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path

from caricli.errors import InputError, OutputError, shown
from caricli.io.files import is_utf8
from caricli.io.image import read_image, write_png
from caricli.structures import Pictures
from caricli.structures.pictures import PICTURED

_LEADING_AWAY = ("/", "\\", "\0", ":")


@dataclass(frozen=True)
class PictureNames:
    """File names of the pictures beside a face, or None. skin, eyes, hair, bust: plain names."""

    skin: str | None = None
    eyes: str | None = None
    hair: str | None = None
    bust: str | None = None

    @property
    def others(self) -> dict[str, str | None]:
        """All but the skin's, by what wears them."""
        return {"eyes": self.eyes, "hair": self.hair, "bust": self.bust}

    def __iter__(self) -> Iterator[str | None]:
        """All of them in the order of ``Pictures``."""
        return (getattr(self, field.name) for field in fields(self))


def picture_outputs(path: Path) -> list[Path]:
    """Where the pictures of a face are written, in the order of ``Pictures``. path: of mesh or NPZ."""
    return [path.with_name(f"{path.stem}-{name}.png") for name in PICTURED.values()]


def worn_paths(path: Path) -> list[Path]:
    """Files that may go beside a face: those of its pictures, and the material of an OBJ. path: of mesh or NPZ."""
    return [*picture_outputs(path), path.with_suffix(".mtl")]


def write_pictures(path: Path, pictures: Pictures) -> PictureNames:
    """Write what there is as PATH-skin.png, PATH-eyes.png and so on. path: of the face. Raises OutputError."""
    if any(picture is not None for picture in pictures) and not (is_utf8(path.name) and is_plain(path.name)):
        expected = "a name in UTF-8 without colons and backslashes, as those of its pictures are kept"
        raise OutputError(f"{shown(path)}: expected {expected}, found another")
    names = []
    for file, picture in zip(picture_outputs(path), pictures, strict=True):
        if picture is not None:
            write_png(file, picture)
        names.append(None if picture is None else file.name)
    return PictureNames(*names)


def read_pictures(path: Path, names: PictureNames) -> Pictures:
    """Read the pictures that a face names. path: of the face.

    Raises InputError when a name leads out of its folder, or no picture is there.
    """
    return Pictures(*(None if name is None else read_image(_beside(path, name)) for name in names))


def is_plain(name: str) -> bool:
    """Whether a name leads to a file beside its own, on any system."""
    return name != ".." and Path(name).name == name and not any(part in name for part in _LEADING_AWAY)


def plain_name(name: str) -> str:
    """The name, which must lead to a file beside its own. Raises InputError where it may lead elsewhere."""
    if not is_plain(name):
        raise InputError(f"expected the name of a file beside it, found {shown(name, 80)!r}")
    return name


def _beside(path: Path, name: str) -> Path:
    picture = path.with_name(plain_name(name))
    if not os.path.isfile(picture):  # also where its name is too long for any file
        raise InputError(f"expected its picture {shown(name, 80)} beside it, found none")
    return picture
