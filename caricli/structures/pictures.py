"""What a face wears."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from caricli.errors import shown
from caricli.structures.checks import refuse
from caricli.structures.materials import FINISHES, Finish, Material, colour_share, toned

PICTURED = {
    Material.SKIN: "skin",
    Material.EYE: "eyes",
    Material.HAIR: "hair",
    Material.BUST: "bust",
}
"""Materials that may wear a picture, and what it is called among Pictures; the others are plain."""

_SPARSE = 4
"""Texels of the skin, along a side, of which one tells whether it has colour."""


@dataclass(frozen=True, eq=False)
class Pictures:
    """What is on a face. skin, eyes, hair, bust: (H, W, 3) uint8 sRGB, the top row first, or None.

    Raises InputError when a picture has another shape or type.
    """

    skin: np.ndarray | None = None
    eyes: np.ndarray | None = None
    hair: np.ndarray | None = None
    bust: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check them all."""
        for name in PICTURED.values():
            if getattr(self, name) is not None:
                refuse(picture_problem(name, np.asarray(getattr(self, name))))

    def __bool__(self) -> bool:
        """Whether there is any."""
        return any(picture is not None for picture in self)

    def __iter__(self) -> Iterator[np.ndarray | None]:
        """All of them in order, None where there is none."""
        return (getattr(self, field.name) for field in fields(self))

    def items(self) -> Iterator[tuple[str, np.ndarray | None]]:
        """All of them with their names."""
        return zip(PICTURED.values(), self, strict=True)

    def of(self, material: Material | int) -> np.ndarray | None:
        """The picture of a material, or None."""
        name = PICTURED.get(Material(material))
        return None if name is None else getattr(self, name)

    @cached_property
    def coloured(self) -> float:
        """From 0, where the skin is in shades of grey, to 1, how far what is plain beside it has its colour."""
        return 1.0 if self.skin is None else colour_share(self.skin[::_SPARSE, ::_SPARSE])

    def with_toned_eyes(self) -> "Pictures":
        """The same, the eyes with as much colour as the skin leaves to what is plain."""
        if self.eyes is None:
            return self
        eyes = np.rint(toned(self.eyes.astype(np.float32), self.coloured)).astype(np.uint8)
        return replace(self, eyes=eyes)

    def finish(self, material: Material | int) -> Finish:
        """How a material looks that wears none of them."""
        return FINISHES[Material(material)].toned(self.coloured)

    @property
    def finishes(self) -> dict[str, Finish]:
        """Those of what wears none of them, by their names, where they are not the usual ones."""
        plain = [] if self.coloured == 1 else [self.finish(each) for each in Material if each not in PICTURED]
        return {finish.name: finish for finish in plain}

    def same(self, other: "Pictures") -> bool:
        """Whether these are like others, texel by texel."""
        return all(_same(*pair) for pair in zip(self, other, strict=True))

    def mixed(self, other: "Pictures", weight: float) -> "Pictures":
        """Between these and others, which have a weight from 0 to 1: their mean where both have one of the same size,
        the one there is where only one has any, else that of the nearer, in the middle of these.
        """
        return Pictures(*(_mixed(*pair, weight) for pair in zip(self, other, strict=True)))


@dataclass(frozen=True, eq=False)
class Mood:
    """The skin in an expression: a picture that stands in for the usual one.

    name: not empty. skin: (H, W, 3) uint8 sRGB, the top row first, on the same UVs.
    Raises InputError when the picture has another shape or type, or there is no name.
    """

    name: str
    skin: np.ndarray

    def __post_init__(self) -> None:
        """Check both."""
        if not isinstance(self.name, str) or not self.name:
            refuse("moods: expected a name for every picture, found none")
        refuse(picture_problem(f"mood {shown(self.name, 60)}", np.asarray(self.skin)))


def picture_problem(key: str, image: np.ndarray) -> str | None:
    """What is wrong with a picture of a name, or None."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or 0 in image.shape:
        return f"{key}: expected (H,W,3) uint8, found {image.shape} {image.dtype}"
    return None


def _same(first: np.ndarray | None, second: np.ndarray | None) -> bool:
    if first is None or second is None:
        return first is second
    return first is second or np.array_equal(first, second)


def _mixed(first: np.ndarray | None, second: np.ndarray | None, weight: float) -> np.ndarray | None:
    if first is None or second is None:
        return second if first is None else first
    if first.shape != second.shape or _same(first, second):
        return first if weight <= 0.5 else second
    mean = np.multiply(first, 1 - weight, dtype=np.float32) + np.multiply(second, weight, dtype=np.float32)
    return np.rint(mean).astype(np.uint8)
