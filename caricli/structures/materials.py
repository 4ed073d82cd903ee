"""What polygons are made of."""

import re
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np


class Material(IntEnum):
    """What a polygon is made of."""

    SKIN = 0
    EYE = 1
    TEETH = 2
    GUMS = 3
    TONGUE = 4
    LASHES = 5
    HAIR = 6
    BUST = 7
    CLOTH = 8


@dataclass(frozen=True)
class Finish:
    """How a material looks where it wears no picture.

    name: in files. colour: sRGB, 0 to 255. roughness: from 0, a mirror, to 1, chalk.
    """

    name: str
    colour: tuple[int, int, int]
    roughness: float

    @property
    def linear(self) -> list[float]:
        """The colour in linear light, 0 to 1."""
        shares = [value / 255 for value in self.colour]
        return [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in shares]

    def toned(self, share: float) -> "Finish":
        """The same with so much of its colour, from 0, grey, to 1."""
        red, green, blue = np.rint(toned(np.array(self.colour, float), share)).astype(int).tolist()
        return replace(self, colour=(red, green, blue))


FINISHES = {
    Material.SKIN: Finish("skin", (206, 160, 136), 0.6),
    Material.EYE: Finish("eyes", (232, 228, 222), 0.2),
    Material.TEETH: Finish("teeth", (240, 233, 216), 0.25),
    Material.GUMS: Finish("gums", (190, 98, 96), 0.3),
    Material.TONGUE: Finish("tongue", (198, 104, 104), 0.4),
    Material.LASHES: Finish("lashes", (38, 28, 24), 0.7),
    Material.HAIR: Finish("hair", (92, 66, 48), 0.7),
    Material.BUST: Finish("bust", (206, 160, 136), 0.7),
    Material.CLOTH: Finish("cloth", (74, 86, 104), 0.9),
}
"""The Finish of every Material."""

MATERIALS = {finish.name: material for material, finish in FINISHES.items()}
"""Materials by their names in files."""

_NUMBER = re.compile(r"\.\d{3}$")


def material_named(name: str) -> Material:
    """The Material of a name in a file, skin where it is another; Blender calls the second ``eyes.001``."""
    return MATERIALS.get(_NUMBER.sub("", name), Material.SKIN)


_GREY, _COLOURED = 4.0, 16.0
"""Differences of 255 between the channels of a picture: grey to the first, coloured from the second."""

_PALER = 0.9
"""Share of its texels that have at most this difference: paper and unused texels may be most of it."""


def colour_share(colours: np.ndarray) -> float:
    """From 0, of a picture in shades of grey, to 1, how far one of colours (..., 3) from 0 to 255 is coloured."""
    difference = float(np.quantile(np.ptp(colours.astype(np.float32), axis=-1), _PALER))
    return float(np.interp(difference, (_GREY, _COLOURED), (0.0, 1.0)))


def toned(colours: np.ndarray, share: float) -> np.ndarray:
    """Colours (..., 3) with so much of their colour, from 0, grey, to 1."""
    mixed: np.ndarray = colours + (1 - share) * (colours.mean(-1, keepdims=True) - colours)
    return mixed


IN_MOUTH = (Material.TEETH, Material.GUMS, Material.TONGUE)
"""What lies behind the lips."""

HEAD_PARTS = {
    "skin": (Material.SKIN,),
    "eyes": (Material.EYE,),
    "teeth": (Material.TEETH, Material.GUMS),
    "tongue": (Material.TONGUE,),
    "lashes": (Material.LASHES,),
    "hair": (Material.HAIR,),
    "bust": (Material.BUST, Material.CLOTH),
}
"""What a head may consist of, by the names that choose it, and what this is made of."""


def material_problem(materials: np.ndarray | None, polygons: int) -> str | None:
    """What is wrong with the materials (P,) of so many polygons, or None."""
    if materials is None:
        return None
    values = np.asarray(materials)
    if values.shape != (polygons,) or not np.isin(values, [*Material]).all():
        return f"materials: expected {[*map(int, Material)]} for every polygon, found others"
    return None
