"""What the network is shown of strokes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.rows_at import rows_at
from caricli.models.sketch.window import Window
from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.structures.sketch import Sketch, Stroke

STEP = 0.024
"""Of a window's half side: between places along a stroke."""

_MOST = 8000
"""Places of a sketch; of longer lines they are further apart."""


def line_picture(lines: Sequence[np.ndarray], window: Window, size: int) -> np.ndarray:
    """Lines (N, 2), pixels of the canvas, in a window as a picture (S, S) uint8, all of one width: 255 where ink is."""
    middle = (size - 1) / 2
    strokes = tuple(Stroke(middle * (1 + window.inside(line))) for line in lines)
    return rasterise_sketch(Sketch(strokes, (size, size)), size)


@dataclass(frozen=True, eq=False)
class Places:
    """Places along strokes, at equal distances.

    about: (N, 4) float32, see ``networks.ABOUT``. owner: (N,) numbers of the strokes, ascending. along: (N,) how far
    along it, shares of its length.
    """

    about: np.ndarray
    owner: np.ndarray
    along: np.ndarray

    @classmethod
    def of(cls, lines: Sequence[np.ndarray], window: Window) -> "Places":
        """Those of lines (N, 2), pixels of the canvas; a dot has one."""
        inside = [window.inside(line) for line in lines]
        reached = [arc_lengths(line) for line in inside]
        step = max(STEP, sum(float(each[-1]) for each in reached) / _MOST)
        own = [_of_line(line, far, step) for line, far in zip(inside, reached, strict=True)]
        counts = [len(along) for _, along in own]
        about = np.concatenate([np.zeros((0, 4)), *(rows for rows, _ in own)])
        along = np.concatenate([np.zeros(0), *(shares for _, shares in own)])
        return cls(about.astype(np.float32), np.repeat(np.arange(len(lines)), counts), along)


def _of_line(line: np.ndarray, reached: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows (N, 4) of places along a line, and the shares (N,) of its length. reached: (M,) lengths up to its points."""
    length = float(reached[-1])
    count = max(round(length / step), 1)
    along = (np.arange(count) + 0.5) / count
    reach = max(step, 1e-9)
    points, before, after = (
        rows_at(np.clip(length * along + shift, 0, length), reached, line) for shift in (0, -reach, reach)
    )
    way = after - before
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
    doubled = np.stack([way[:, 0] ** 2 - way[:, 1] ** 2, 2 * way[:, 0] * way[:, 1]], 1)
    return np.hstack([points, doubled]), along
