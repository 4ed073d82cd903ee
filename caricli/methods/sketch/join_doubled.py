"""Lines that were searched for with several strokes beside each other, as one."""

import numpy as np

from caricli.geometry.lines.trace_lines import InkLine, trace_lines

_SIDE = 0.023
"""Of the longer side of a drawing: lines so near, and along each other, are one that was searched for."""
_ALONG = 0.9
"""Cosine between lines along each other, at least."""
_DOUBLED = 0.15
"""Share of the length of a drawing that has another line beside it from which on it was searched for; likewise of what
is outside, as lids, lips and their folds lie beside each other in any drawing."""
_OUTSIDE = 0.8
"""Of half a drawing's width and height: what is farther from its middle is outside."""
_JOINED = 0.1
"""The same share at which its lines are joined."""
_GAPS = (0.0035, 0.006, 0.009)
"""Of the longer side of a drawing: half of the gaps that are filled, one after the other."""


def trace_joined(ink: np.ndarray, shortest: float, side: float) -> list[InkLine]:
    """Lines of ink (H, W) bool, as ``trace_lines`` has them; gaps between strokes along each other are filled before,
    where much of a drawing is drawn so. side: pixels, the longer one of the drawing."""
    lines = trace_lines(ink, shortest)
    enough = _DOUBLED
    for gap in _GAPS:
        if _doubled(lines, _SIDE * side) <= enough:
            break
        enough = _JOINED
        lines = trace_lines(_filled(ink.astype(np.uint8), gap * side).astype(bool), shortest)
    return lines


def shades_along(lines: list[InkLine], dark: np.ndarray, side: float) -> list[np.ndarray]:
    """(N,) how dark (H, W) each line is at its points; between strokes that were joined, as dark as these. side:
    pixels, the longer one of the drawing."""
    filled = _filled(dark, _GAPS[-1] * side)
    return [filled[tuple(line.points.round().astype(int).T[::-1])] for line in lines]


def _filled(picture: np.ndarray, gap: float) -> np.ndarray:
    """(H, W) with what lies between bright strokes as bright as they are. gap: half of its width, pixels."""
    import cv2

    size = (2 * max(round(gap), 1) + 1,) * 2
    return cv2.morphologyEx(picture, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, size))


def _doubled(lines: list[InkLine], near: float) -> float:
    """Share of the points of lines that have another line along them and beside them; of those outside, where that is
    less. near: pixels."""
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
    doubled = np.zeros(len(points), bool)
    doubled[[*first[pairs], *second[pairs]]] = True
    low, high = points.min(0), points.max(0)
    outside = np.linalg.norm((points - (low + high) / 2) / np.maximum((high - low) / 2, 1), axis=1) > _OUTSIDE
    return float(min(doubled.mean(), doubled[outside].mean()))
