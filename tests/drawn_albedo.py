"""The random skin that several folders of tests paint heads with."""

import numpy as np

from caricli.data.appearance import random_appearance
from caricli.data.texture_painter import TexturePainter


def soft_skin(template):
    """(256, 256, 3) uint8 sRGB in the UVs of a template."""
    return TexturePainter(template, 256).draw(random_appearance(np.random.default_rng(3), "soft"))
