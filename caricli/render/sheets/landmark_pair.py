"""Landmarks before and after, side by side."""

from collections.abc import Mapping

import numpy as np

from caricli.render.backdrop import blank_paper
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.overlay import draw_landmarks

_MARGIN = 0.15
"""Of a drawing's side, on each: for the dots, and so that nothing touches the border."""

COLOURS = {"normal": (30, 110, 200), "caricature": (215, 40, 40)}
"""sRGB by what landmarks show."""


def landmark_pair(pair: Mapping[str, np.ndarray], size: int) -> np.ndarray:
    """Draw two sets of landmarks side by side, at one scale.

    pair: (L, 2) pixels by keys of COLOURS; the given ones first, then those that they were mapped to. size: pixels,
    side of a drawing.
    Returns (H, W, 3) uint8.
    """
    both = np.concatenate(list(pair.values()))
    low = both.min(0)
    extent = np.ptp(both, axis=0)
    zoom = size * (1 - 2 * _MARGIN) / extent.max()
    paper = blank_paper(size, size)
    pictures = [
        draw_landmarks(paper, (points - low - extent / 2) * zoom + size / 2, COLOURS[name])
        for name, points in pair.items()
    ]
    labels = [f"{name}, {what}" for name, what in zip(pair, ("given", "mapped"), strict=True)]
    return contact_sheet(pictures, 2, labels)
