"""What a brush drew in an SVG: filled outlines as the lines in their middles."""

from collections.abc import Sequence

import numpy as np

from caricli.errors import InputError
from caricli.geometry.lines.trace_lines import InkLine, trace_lines

_SLENDER = 12.0
"""How many times as long as wide a mark of a brush is, at least."""
_ACROSS = 5.0
"""Pixels of the mask across a mark, about."""
_SIDES = (128.0, 1536.0)
"""Pixels of the longer side of the mask, at least and at most."""
_MOST_PIXELS = 2**26
"""Of all masks of a drawing."""
_STUB = 2.0
"""Of the width: what is shorter is an end of a mark that splits."""


class Brush:
    """Finds the marks of a drawing's brushes, on masks of some pixels together."""

    def __init__(self) -> None:
        self.pixels = 0

    def lines(self, rings: Sequence[np.ndarray], even_odd: bool) -> list[InkLine]:
        """The lines in the middle of a filled shape that is long and thin, as programs write what a brush drew.

        rings: (N, 2) pixels, all outlines of the shape. even_odd: whether it is filled by that rule.
        Returns InkLines, the longest first; none where the shape is open, or no mark of a brush. Raises InputError
        where there is more than a hand draws.
        """
        import cv2

        if not rings or not all(len(ring) > 3 and np.allclose(ring[0], ring[-1], atol=1e-3) for ring in rings):
            return []
        length = sum(np.linalg.norm(np.diff(ring, axis=0), axis=1).sum() for ring in rings) / 2
        places = np.concatenate(rings)
        extents = np.ptp(places, axis=0)
        extent = float(extents.max())
        areas = [cv2.contourArea((ring - ring[0]).astype(np.float32), oriented=True) for ring in rings]
        width = abs(sum(areas)) / max(length, 1e-9)
        if extent < 1e-6 or width < 1e-6 * extent:
            return []
        least, most = _SIDES
        zoom = float(np.clip(_ACROSS / width, least / extent, most / extent))
        self.pixels += int((zoom * extents + 4).prod())
        if self.pixels > _MOST_PIXELS:
            raise InputError("expected fewer or smaller shapes that a brush drew, found more than a hand draws")
        corner = places.min(0) - 2 / zoom
        mask = _filled([(ring - corner) * zoom for ring in rings], even_odd)
        across = float(mask.sum()) / (length * zoom)
        if length * zoom < _SLENDER * across:
            return []
        lines = trace_lines(mask, _STUB * across)
        return [InkLine(line.points / zoom + corner, line.width / zoom) for line in lines if len(line.points) > 1]


def _filled(rings: Sequence[np.ndarray], even_odd: bool) -> np.ndarray:
    """(H, W) bool: what closed lines (N, 2), pixels right of and below 0, fill."""
    import cv2

    starts = np.concatenate([ring[:-1] for ring in rings])
    ends = np.concatenate([ring[1:] for ring in rings])
    width, height = np.ceil(starts.max(0)).astype(int) + 3
    first, last = (np.ceil(np.minimum(starts, ends)[:, 1]), np.ceil(np.maximum(starts, ends)[:, 1]))
    counts = (last - first).astype(int)
    edges = np.repeat(np.arange(len(starts)), counts)
    rows = (first[edges] + np.arange(len(edges)) - np.repeat(np.cumsum(counts) - counts, counts)).astype(int)
    ways = ends[edges] - starts[edges]
    columns = np.ceil(starts[edges, 0] + (rows - starts[edges, 1]) * ways[:, 0] / ways[:, 1]).astype(int)
    turns = np.zeros((height, width), np.int32)
    np.add.at(turns, (rows, columns), np.sign(ways[:, 1]).astype(np.int32))
    turns = np.cumsum(turns, axis=1)
    mask = (turns % 2 == 1 if even_odd else turns != 0).astype(np.uint8)
    # What is thinner than a pixel hangs together by its outline.
    cv2.polylines(mask, [np.round(ring).astype(np.int32) for ring in rings], True, 1)
    return mask > 0
