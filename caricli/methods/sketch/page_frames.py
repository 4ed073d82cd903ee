"""Frames that were drawn around a face, along the edges of a page or of a panel."""

from collections.abc import Sequence

import numpy as np

_CLOSED = 0.05
"""Of its length: the ends of a frame are nearer to each other."""
_STRAIGHT = 0.02
"""Of its longer side: as near to the sides of its box all of a frame is."""
_MOST = 0.5
"""Share of the other lines that a face holds, at least."""


def page_frames(lines: Sequence[np.ndarray]) -> list[int]:
    """Numbers of the lines that are frames: closed rectangles around a line that goes around most others itself.

    lines: of (N, 2). A rectangle without such a line in it may be a face.
    """
    low, high = (np.array([bound(line, axis=0) for line in lines]).reshape(-1, 2) for bound in (np.min, np.max))
    middles = (low + high) / 2
    rest = np.ones(len(lines), bool)
    frames: list[int] = []
    for number in np.argsort(-(high - low).sum(1), kind="stable").tolist():
        rest[number] = False
        within = np.flatnonzero(rest & (low > low[number]).all(1) & (high < high[number]).all(1))
        if not _is_rectangle(lines[number]) or not len(within) or len(within) < _MOST * rest.sum():
            break
        face = within[(high[within] - low[within]).sum(1).argmax()]
        others = np.delete(within, np.flatnonzero(within == face))
        held = ((middles[others] > low[face]) & (middles[others] < high[face])).all(1)
        if not len(held) or held.mean() < _MOST:
            break
        frames.append(number)
    return frames


def _is_rectangle(line: np.ndarray) -> bool:
    """Whether a line (N, 2) runs along the four sides of its box."""
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    low, size = line.min(0), np.ptp(line, axis=0)
    slack = _STRAIGHT * size.max()
    if np.linalg.norm(line[0] - line[-1]) > _CLOSED * lengths.sum() or size.min() < 4 * slack:
        return False
    steps = np.concatenate([line, (line[1:] + line[:-1]) / 2])
    near = np.concatenate([np.abs(steps - low), np.abs(steps - low - size)], axis=1)
    corners = low + size * np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    met = np.linalg.norm(line[:, None] - corners, axis=2).min(0)
    return bool((near.min(1) < slack).all() and (met < 4 * slack).all())
