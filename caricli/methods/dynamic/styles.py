"""Styles that textures are painted in: the same one for all expressions of a person, so that pairs stay pairs."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from caricli.data.appearance import random_appearance
from caricli.methods.dynamic.lit_faces import LitFaces
from caricli.methods.dynamic.media import Medium, random_medium
from caricli.methods.pictures.light import random_sky
from caricli.models.style.model import Look, StyleModel
from caricli.template.template import Template

SIDE = 128
"""Of a style picture, pixels: as of the textures that the network was trained on."""

LENT = 0.4
"""How many styles are lent from drawings; the others are media."""

LEAST_PART = 0.5
"""Least side of the part of a drawing that a style is taken from, of its shorter side."""

WEAKEST = 0.6
"""Least strength of a style that is lent."""


@dataclass(frozen=True, eq=False)
class LentLook:
    """The look of a drawing. model: StyleModel. look: Look. strength, seed: see ``StyleModel.lend``."""

    model: StyleModel
    look: Look
    strength: float
    seed: int


@dataclass(frozen=True, eq=False)
class Style:
    """One style: a medium, or the look of a drawing."""

    way: Medium | LentLook

    @property
    def name(self) -> str:
        """Of the medium, or "drawing"."""
        return self.way.name if isinstance(self.way, Medium) else "drawing"

    def paint(self, pictures: np.ndarray) -> np.ndarray:
        """Paint the textures of one person (..., H, W, 3) uint8: those of all expressions together.

        Where two of them are equal, and around it, they still are; strokes of all go the ways of their mean. Texels
        that show nothing should be continued from their neighbours before, as by ``pad_texture``. The same pictures
        give the same bytes.
        Returns an array like them.
        """
        rows = pictures.reshape(-1, *pictures.shape[-3:])
        if isinstance(self.way, Medium):
            guide = np.round(rows.mean(0)).astype(np.uint8)
            painted = np.stack([self.way.paint(picture, guide) for picture in rows])
        else:
            painted = self.way.model.lend(rows, self.way.look, self.way.strength, self.way.seed)
        return painted.reshape(pictures.shape)


class StyleBook:
    """Styles to draw from."""

    def __init__(self, model: StyleModel | None = None, drawings: Sequence[np.ndarray] = ()) -> None:
        """model: that lends looks. drawings: pictures (H, W, 3) uint8 whose looks are lent; see ``drawn_faces``.

        Without one of them all styles are media.
        """
        self.model = model
        self.drawings = drawings

    def draw(self, generator: np.random.Generator) -> Style:
        """Draw a Style."""
        if self.model is None or not self.drawings or generator.random() >= LENT:
            return Style(random_medium(generator))
        drawing = self.drawings[int(generator.integers(len(self.drawings)))]
        look = self.model.look(_part(drawing, generator))
        strength = float(generator.uniform(WEAKEST, 1))
        return Style(LentLook(self.model, look, strength, int(generator.integers(2**32))))


def drawn_faces(template: Template, count: int, seed: int) -> list[np.ndarray]:
    """Generated style pictures (SIDE, SIDE, 3) uint8: faces of a template with UVs in all media."""
    faces = LitFaces(template, SIDE)
    generator = np.random.default_rng(seed)
    return [
        random_medium(generator).paint(faces.draw(random_appearance(generator), random_sky(generator)))
        for _ in range(count)
    ]


def _part(drawing: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """A square part of a drawing, somewhere about its middle, SIDE pixels wide."""
    height, width = drawing.shape[:2]
    side = max(1, round(generator.uniform(LEAST_PART, 1) * min(height, width)))
    top, left = (round(generator.beta(3, 3) * (length - side)) for length in (height, width))
    part = drawing[top : top + side, left : left + side]
    return cv2.resize(part, (SIDE, SIDE), interpolation=cv2.INTER_AREA if side > SIDE else cv2.INTER_LINEAR)
