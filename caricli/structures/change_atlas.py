"""What expressions do to the picture of a skin, each by itself, in one picture."""

from dataclasses import dataclass

import numpy as np

from caricli.limits import MAX_CHANGE, MAX_NUMBER
from caricli.structures.checks import refuse
from caricli.structures.pictures import picture_problem

NOTHING = 128
"""The byte of a tile that means 0; 255 and 1 mean plus and minus the largest value."""


@dataclass(frozen=True, eq=False)
class ChangeAtlas:
    """T' = T + sum_k w_k (G_k T + O_k) at every texel of a window of the skin's picture, sRGB from 0 to 1.

    picture: (H, W, 3) uint8, square tiles in rows from the top left: G_0, O_0, G_1, O_1, ... Number 0 is what the
    picture is at rest and always has the weight 1; the others are those of the rig's expressions, in their order.
    columns: tiles in a row. side: texels of a tile. window: left, top, right and bottom of what a tile covers in the
    skin's picture, from 0 to 1, from the top left. gain, offset: what the byte 255 means in G and in O; 128 is 0.
    Raises InputError when they do not fit each other.
    """

    picture: np.ndarray
    columns: int
    side: int
    window: tuple[float, float, float, float]
    gain: float
    offset: float

    def __post_init__(self) -> None:
        """Check that the tiles fit in."""
        refuse(picture_problem("changes", np.asarray(self.picture)))
        if self.side < 1 or self.columns < 1 or self.picture.shape[1] < self.columns * self.side:
            refuse(f"changes: expected rows of tiles, found {self.columns} of {self.side} in {self.picture.shape}")
        left, top, right, bottom = self.window
        if not (0 <= left < right <= 1 and 0 <= top < bottom <= 1):
            refuse(f"changes: expected a window inside the picture, found {self.window}")
        if not (0 <= self.gain <= MAX_CHANGE and 0 <= self.offset <= MAX_CHANGE):
            refuse(f"changes: expected a gain and an offset up to {MAX_CHANGE}, found {self.gain} and {self.offset}")

    @classmethod
    def laid_out(cls, picture: np.ndarray, layout: np.ndarray) -> "ChangeAtlas":
        """The atlas of a picture and its ``layout`` (8,). Raises InputError as it does, and for another layout."""
        values = np.asarray(layout, float).ravel()
        if values.shape != (8,) or not (np.abs(values) < MAX_NUMBER).all():
            refuse(f"change_layout: expected eight numbers, found {np.shape(layout)}")
        left, top, right, bottom = values[2:6].tolist()
        return cls(picture, int(values[0]), int(values[1]), (left, top, right, bottom), *values[6:].tolist())

    @property
    def layout(self) -> np.ndarray:
        """(8,) all numbers: columns, side, the four of the window, gain and offset."""
        return np.array([self.columns, self.side, *self.window, self.gain, self.offset])

    @property
    def count(self) -> int:
        """How many tiles there is room for."""
        return self.columns * (len(self.picture) // self.side)
