"""What an expression does to a texture."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class TextureChange:
    """T' = T + A (G T + O) at every texel of a chart, sRGB from 0 to 1, rows from the top.

    attention: A, (S, S) 0 to 1. gain: G, (S, S, 3). offset: O, (S, S, 3).
    """

    attention: np.ndarray
    gain: np.ndarray
    offset: np.ndarray

    def paint(self, picture: np.ndarray) -> np.ndarray:
        """A texture (S, S, 3), uint8 sRGB, as it becomes."""
        colours = picture / 255.0
        changed = colours + self.attention[..., None] * (self.gain * colours + self.offset)
        return np.rint(255 * np.clip(changed, 0, 1)).astype(np.uint8)
