"""Pictures of textured heads without any light."""

import numpy as np

from caricli.render.textured_colours import textured_colours


def render_textured(rig, placed, width, height, **options):
    """(height, width, 3) uint8; for the arguments see `textured_colours`."""
    return np.clip(np.round(textured_colours(rig, placed, width, height, **options)), 0, 255).astype(np.uint8)
