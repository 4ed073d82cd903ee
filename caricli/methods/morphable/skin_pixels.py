"""Where a parsed picture shows bare skin of a face."""

import numpy as np

from caricli.structures.parsing import Region

BARE = (Region.SKIN, Region.BROWS, Region.NOSE, Region.LIPS)
"""What the colours of a morphable model stand for."""


def skin_pixels(regions: np.ndarray) -> np.ndarray:
    """The confidence map of equation 5: (H, W) 1 where a label map (H, W) shows what BARE names, else 0."""
    return np.isin(regions, BARE).astype(float)
