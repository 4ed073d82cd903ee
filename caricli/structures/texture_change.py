"""What an expression does to a texture."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class TextureChange:
    """T' = T + G T + O at every texel of a chart, sRGB from 0 to 1, rows from the top; attention is in both.

    gain: G, (S, S, 3). offset: O, (S, S, 3).
    """

    gain: np.ndarray
    offset: np.ndarray

    def paint(self, picture: np.ndarray) -> np.ndarray:
        """A texture (S, S, 3), uint8 sRGB, as it becomes."""
        colours = picture / 255.0
        return np.rint(255 * np.clip(colours + self.gain * colours + self.offset, 0, 1)).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class Manner:
    """How a picture paints what is darker: colours become as many times what they were as the luminance does, each
    channel to a power of its own.

    shades: (3,) the powers, all 1 where shades keep their hue. share: (S, S) from 0 to 1, how far texels of a chart
    change in this manner. skin: (S, S) from 0 to 1, where they are skin that folds. deepest: logarithm of luminance by
    which a fold is darker than the skin around it at the most. coloured: from 0, where it is in shades of grey, to 1.
    """

    shades: np.ndarray
    share: np.ndarray
    skin: np.ndarray
    deepest: float
    coloured: float = 1.0
