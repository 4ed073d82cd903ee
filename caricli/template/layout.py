"""Where the head lies in its picture."""

from functools import cache

import numpy as np

from caricli.io.bundled import asset_path
from caricli.io.npz import read_npz

LAYOUT_FILE = "head_layout.npz"
"""Of the assets."""


@cache
def bundled_layout() -> dict[str, np.ndarray]:
    """The ``uvs`` (T, 2) and ``uv_polygons`` (P, 4) of the bundled head, as a Mesh takes them."""
    return read_npz(asset_path(LAYOUT_FILE))
