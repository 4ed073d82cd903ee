"""Media that textures are painted in, stroke by stroke the same for every picture of a person."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from caricli.methods.pictures.media import MEDIA
from caricli.methods.stylise.canvas import Canvas
from caricli.methods.stylise.draw_ink import InkSettings, draw_ink
from caricli.methods.stylise.draw_pencil import PencilSettings, draw_pencil
from caricli.methods.stylise.paint_oil import OilSettings, paint_oil
from caricli.methods.stylise.paint_picture import PAINTERS
from caricli.render.pixels.levels import to_bytes, to_floats

NEAR_PAINTERS: dict[str, Callable[[Canvas], np.ndarray]] = PAINTERS | {
    "oil": partial(paint_oil, settings=OilSettings(brushes=(2.0, 1.0, 0.5, 0.3), steps=4)),
    "ink": partial(draw_ink, settings=InkSettings(contrast=0.0, bend=0.0)),
    "pencil": partial(draw_pencil, settings=PencilSettings(contrast=0.0, stroke=7.0, shade=0.6, grain=0.25)),
}
"""The painters of ``caricli stylise``, such that strokes depend on nothing far from them, and leave the face."""

OF_PICTURES = {
    "painted": "painted",
    "outlined": "inked",
    "hatched": "hatched",
    "pencilled": "pencil",
    "posterised": "flat",
    "printed": "halftone",
    "photographed": "photograph",
}
"""The media of generated pictures, under names that no painter has."""

NAMES = (*NEAR_PAINTERS, *OF_PICTURES)

UNITS = {"pencil": (1.0, 2.0), "ink": (1.5, 3.5)}
USUAL = (2.0, 4.5)
"""Least and greatest units of painters, pixels of a picture of ``PAINTED``; a hundredth of its face is about 2.5."""

PAINTED = 256
"""Side, pixels, in which pictures are painted at least, so that strokes may be finer than texels."""


@dataclass(frozen=True)
class Medium:
    """One medium with all that is random in it.

    name: of NAMES. unit: size of strokes, pixels of a picture whose shorter side is PAINTED. seed: of strokes and
    grain.
    """

    name: str
    unit: float
    seed: int

    def paint(self, picture: np.ndarray, guide: np.ndarray | None = None) -> np.ndarray:
        """Paint a picture (H, W, 3) uint8. Strokes and grain are where they are in every other picture of this size.

        guide: picture of the same size whose ways strokes go, so that they go alike in several pictures; or None for
        the picture's own.
        Returns an array like it.
        """
        height, width = picture.shape[:2]
        scale = max(1, -(-PAINTED // min(height, width)))
        larger = (scale * width, scale * height)
        both = (picture, picture if guide is None else guide)
        image, ways = (to_floats(cv2.resize(one, larger, interpolation=cv2.INTER_CUBIC)) for one in both)
        return cv2.resize(to_bytes(self._painted(image, ways)), (width, height), interpolation=cv2.INTER_AREA)

    def _painted(self, image: np.ndarray, guide: np.ndarray) -> np.ndarray:
        """Values from 0 to 1 (H, W, 3) painted along the ways of others."""
        generator = np.random.default_rng(self.seed)
        height, width = image.shape[:2]
        if self.name in NEAR_PAINTERS:
            care = np.ones((height, width), np.float32)
            unit = self.unit * min(height, width) / PAINTED
            return NEAR_PAINTERS[self.name](Canvas(image, unit, care, generator, guide))
        side = max(height, width)
        square = cv2.copyMakeBorder(image, 0, side - height, 0, side - width, cv2.BORDER_REPLICATE)
        paint = MEDIA[OF_PICTURES[self.name]][0]
        return paint(square, np.zeros((side, side), np.uint8), generator)[:height, :width]


def random_medium(generator: np.random.Generator, name: str | None = None) -> Medium:
    """Draw a Medium, of any name or of one."""
    chosen = str(generator.choice(NAMES)) if name is None else name
    unit = float(np.exp(generator.uniform(*np.log(UNITS.get(chosen, USUAL)))))
    return Medium(chosen, unit, int(generator.integers(2**32)))
