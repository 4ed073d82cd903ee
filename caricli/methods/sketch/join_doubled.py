"""Lines that were searched for with several strokes beside each other, as one."""

import numpy as np

from caricli.geometry.lines.trace_lines import InkLine, trace_lines

_SIDE = 0.02
"""Of the longer side of a picture: lines so near, and along each other, are one that was searched for."""
_ALONG = 0.9
"""Cosine between lines along each other, at least."""
_DOUBLED = 0.2
"""Share of the length of a drawing that has another line beside it from which on it was searched for."""
_JOINED = 0.1
"""The same share at which its lines are joined."""
_GAPS = (0.003, 0.005, 0.008)
"""Of the longer side: half of the gaps that are filled, one after the other."""


def trace_joined(ink: np.ndarray, shortest: float) -> list[InkLine]:
    """Lines of ink (H, W) bool, as ``trace_lines`` has them; gaps between strokes along each other are filled before,
    where much of a drawing is drawn so."""
    lines = trace_lines(ink, shortest)
    longer = max(ink.shape)
    enough = _DOUBLED
    for gap in _GAPS:
        if _doubled(lines, _SIDE * longer) <= enough:
            break
        enough = _JOINED
        lines = trace_lines(_filled(ink.astype(np.uint8), gap).astype(bool), shortest)
    return lines


def shades_along(lines: list[InkLine], dark: np.ndarray) -> list[np.ndarray]:
    """(N,) how dark (H, W) each line is at its points; between strokes that were joined, as dark as these."""
    filled = _filled(dark, _GAPS[-1])
    return [filled[tuple(line.points.round().astype(int).T[::-1])] for line in lines]


def _filled(picture: np.ndarray, gap: float) -> np.ndarray:
    """(H, W) with what lies between bright strokes as bright as they are. gap: half of its width, of the side."""
    import cv2

    side = 2 * max(round(gap * max(picture.shape)), 1) + 1
    return cv2.morphologyEx(picture, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)))


def _doubled(lines: list[InkLine], near: float) -> float:
    """Share of the points of lines that have another line along them and beside them. near: pixels."""
    from scipy.spatial import KDTree

    lines = [line for line in lines if len(line.points) > 2]
    if not lines:
        return 0.0
    points = np.concatenate([line.points for line in lines])
    ways = np.concatenate([np.gradient(line.points, axis=0) for line in lines])
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-9)
    numbers = np.repeat(np.arange(len(lines)), [len(line.points) for line in lines])
    first, second = KDTree(points).query_pairs(near, output_type="ndarray").T
    apart = points[second] - points[first]
    along = (apart * ways[first]).sum(1)
    beside = np.abs(along) < np.linalg.norm(apart - along[:, None] * ways[first], axis=1)
    parallel = np.abs((ways[first] * ways[second]).sum(1)) > _ALONG
    pairs = (numbers[first] != numbers[second]) & beside & parallel
    return len(np.union1d(first[pairs], second[pairs])) / len(points)
