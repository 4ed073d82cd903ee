"""A change of texture at the resolution of the texture itself."""

import cv2
import numpy as np

from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import ChartGrid, chart_to_texture
from caricli.render.pixels.levels import to_bytes
from caricli.structures import Mesh
from caricli.structures.texture_change import TextureChange

_BORDER = 0.04
"""Of the chart's side: how far inside its border a change has come to its full strength."""


class ChangedTexture:
    """A head's texture that takes changes of its face.

    Where the face lies in the texture is found once, so that many changes, as of a film, cost little.
    """

    def __init__(self, picture: np.ndarray, template: Mesh, grid: ChartGrid) -> None:
        """picture: (H, H, 3) uint8 sRGB, the head's texture. template: Mesh with UVs. grid: of the changes.

        Raises InputError where the texture shows nothing of the face.
        """
        size = len(picture)
        side = np.arange(grid.size, dtype=np.float32)
        places = np.stack(np.meshgrid(side, side), axis=-1)
        spots = chart_to_texture(np.dstack([places, inside_chart(grid)]), template, grid, size)
        self.picture = picture
        rows = np.flatnonzero(spots[..., 2].max(1) > 0)
        columns = np.flatnonzero(spots[..., 2].max(0) > 0)
        if not len(rows):
            raise InputError("dynamic texture needs UVs that lay the face in its picture, found none of it there")
        self.window = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
        self.at = spots[self.window][..., :2]
        self.strength = spots[self.window][..., 2:]
        self.colours = picture[self.window] / np.float32(255)

    def paint(self, change: TextureChange) -> np.ndarray:
        """(H, H, 3) uint8, the texture with a change: slow in its own texels, the fine ones of the picture kept."""
        gain, offset = self.spread(change)
        colours = self.colours + gain * self.colours + offset
        painted = self.picture.copy()
        painted[self.window] = to_bytes(colours)
        return painted

    def spread(self, change: TextureChange) -> tuple[np.ndarray, np.ndarray]:
        """Gain and offset (H, W, 3) float32 of a change at the texels of the window, fading at its border."""
        return self.strength * self._enlarged(change.gain), self.strength * self._enlarged(change.offset)

    def _enlarged(self, values: np.ndarray) -> np.ndarray:
        """Values (S, S, 3) of the chart at the texels of the window."""
        rows, columns = np.moveaxis(self.at, -1, 0)[::-1]
        return cv2.remap(values.astype(np.float32), columns, rows, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


def inside_chart(grid: ChartGrid) -> np.ndarray:
    """(S, S) from 0 at the border of the chart to 1 inside; its holes are no border."""
    outline = grid.covered.astype(np.uint8)
    contours, _ = cv2.findContours(outline, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    whole = cv2.drawContours(outline, contours, -1, 1, cv2.FILLED)
    framed = np.pad(whole, 1)
    away = cv2.distanceTransform(framed, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    return np.clip((away - 1) / (_BORDER * grid.size), 0, 1)
