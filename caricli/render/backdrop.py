"""What stands behind every head that is drawn: a pool of light on the paper of the sheets."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.render.pixels.blend import over
from caricli.render.pixels.paint import mix

PAPER = (224, 221, 217)
"""sRGB of the sheets, around and between their pictures."""

_GLOW = (248, 247, 245)
_HEIGHT = 0.44  # of the picture's height, from the top: where the pool is brightest


@lru_cache(maxsize=8)
def backdrop(height: int, width: int) -> np.ndarray:
    """A pool of light that is all paper at the picture's edges, so that neighbours on a sheet show no border.

    Returns (height, width, 3) uint8, not to be written to.
    """
    y = (np.arange(height) + 0.5) / height
    x = (np.arange(width) + 0.5) / width
    down = np.where(y < _HEIGHT, (_HEIGHT - y) / _HEIGHT, (y - _HEIGHT) / (1 - _HEIGHT))
    away = np.hypot(down[:, None], 2 * np.abs(x - 0.5))
    picture = mix(np.array(_GLOW, float), np.array(PAPER, float), smooth_step(away, 0.1, 1.0))
    picture = np.rint(picture).astype(np.uint8)
    picture.flags.writeable = False
    return picture


def on_backdrop(image: np.ndarray) -> np.ndarray:
    """Lay a picture (H, W, 3 or 4) uint8 over a backdrop of its own; returns (H, W, 3) uint8."""
    return image if image.shape[2] == 3 else over(image, backdrop(*image.shape[:2]))


def row_of(images: Sequence[np.ndarray]) -> np.ndarray:
    """Pictures of one height side by side, each on its backdrop; returns (H, W, 3) uint8."""
    return np.hstack([on_backdrop(image) for image in images])


def blank_paper(height: int, width: int) -> np.ndarray:
    """Paper to draw lines on, (height, width, 3) uint8."""
    return np.full((height, width, 3), PAPER, np.uint8)
