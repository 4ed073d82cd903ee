"""How a picture of a face paints its skin darker, told from the picture itself."""

import cv2
import numpy as np

from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.structures.materials import colour_share
from caricli.structures.texture_change import Manner
from caricli.template.template import Template

_SKIN = ("forehead", "cheek_left", "cheek_right", "chin")
_OTHER = ("brow_left", "brow_right", "eyes_left", "eyes_right", "nostril_left", "nostril_right", "lips")

_SHARE = 0.7
"""How far skin changes in its picture's own manner: the mean of all media that a network learns from makes olive and
grey folds in bright paint."""

_USUAL = np.array([0.87, 1.05, 1.08])
"""Powers of red, green and blue: shade is redder. Medians of generated people, in their own look and in styles."""

_FAINT = 0.01
"""Root of the mean square of logarithms of luminance that says as much of a picture's shades as what is usual."""

_WIDE = 16
"""Of a chart's side: how wide what shades are measured against is."""

_FINE = (0.0104, 0.0365)
"""Of a chart's side: how wide the finest and the widest shades are that folds are compared with."""

_DARKEST = 97
"""Percent of the skin that have fainter fine shades than its darkest."""

_MORE = 0.02
"""Of logarithms of luminance: how much deeper than these a fold may be. Blurred folds that stand out of clean skin read
as dirt."""

_RIM = 7  # texels about the mouth, where what is dark is no fold
_DARK = 0.02
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class MannerReader:
    """Reads the Manner of pictures in the chart of a face.

    zone: (S, S) bool, texels of skin without brows, eyes, nostrils and lips.
    """

    def __init__(self, grid: ChartGrid, template: Template) -> None:
        """grid: ChartGrid of the pictures. template: Template of its mesh."""
        regions = np.stack([template.mask(*_SKIN), template.mask(*_OTHER)], axis=1)
        skin, other = np.moveaxis(grid.bake(regions.astype(np.float32)), -1, 0)
        zone = (skin > 1 - _DARK) & (other == 0) & ~grid.mouth
        self.zone = cv2.erode(zone.astype(np.uint8), np.ones((3, 3))) > 0
        near = cv2.dilate(grid.mouth.astype(np.uint8), np.ones((_RIM, _RIM)))
        self.skin = cv2.GaussianBlur(1 - near.astype(np.float32), (0, 0), 1) * (grid.covered & (near == 0))
        # What is between the lips is no skin.
        self.share = np.where(grid.mouth, 0.0, _SHARE).astype(np.float32)

    def read(self, picture: np.ndarray) -> Manner:
        """Of a picture (S, S, 3) uint8 sRGB.

        shades: b that minimises the sum over darker texels of |log c - b log Y|², c the colours and Y their luminance,
        both without what is slow among skin, drawn to what is usual where a picture hardly has shades.
        """
        colours = np.maximum(picture / 255, _DARK)
        skin = self.zone[..., None].astype(np.float32)
        logs = skin * np.log(np.dstack([colours, colours @ _LUMINANCE, np.full(skin.shape, np.e)])).astype(np.float32)
        slow = cv2.GaussianBlur(logs, (0, 0), len(picture) / _WIDE)
        fine = (logs - slow / np.maximum(slow[..., 4:], _DARK))[self.zone]
        darker = fine[fine[:, 3] < 0].astype(float)
        told = (darker[:, 3] ** 2).sum()
        little = _FAINT**2 * max(len(darker), 1)
        shades = ((darker[:, :3] * darker[:, 3:4]).sum(0) + little * _USUAL) / (told + little)
        coloured = colour_share(picture[self.zone]) if self.zone.any() else 1.0
        return Manner(shades.astype(np.float32), self.share, self.skin, self._deepest(colours), coloured)

    def _deepest(self, colours: np.ndarray) -> float:
        """Of colours (S, S, 3) from 0 to 1: the darkest of their fine shades, and a little more."""
        shades = np.log(np.maximum(colours @ _LUMINANCE, _DARK))
        fine, wide = (cv2.GaussianBlur(shades, (0, 0), width * len(colours)) for width in _FINE)
        darker = np.maximum(wide - fine, 0)[self.zone]
        return _MORE + (float(np.percentile(darker, _DARKEST)) if len(darker) else 0.0)
