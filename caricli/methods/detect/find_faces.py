"""Where faces may be in a picture, of any size."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from caricli.methods.detect.parse_picture import WindowRegions
from caricli.methods.detect.settings import DetectSettings
from caricli.models.detector.model import Detector, FaceCells
from caricli.render.pixels.cut_window import cut_window
from caricli.structures.detection import FaceFrame

_LEAST = 1e-9
"""Area in square pixels that nothing is divided by less than."""

_MULTIPLE = 32
"""Pixels that the sides of a window are multiples of."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """Where a face may be: FaceFrame in the picture, and score from 0 to 1."""

    frame: FaceFrame
    score: float


def find_faces(
    picture: np.ndarray, detector: Detector, sides: tuple[float, ...], settings: DetectSettings
) -> tuple[list[Candidate], list[WindowRegions]]:
    """Search a picture (H, W, 3) uint8 at several scales.

    sides: what its longer side is made for each, in sides of the detector's windows.
    Returns where faces may be, the best first and each once, and what the picture shows by every scale.
    """
    candidates: list[Candidate] = []
    glances = []
    for side in sides:
        scale = side * detector.size / max(picture.shape[:2])
        size = [_MULTIPLE * ceil((round(length * scale) + 1) / _MULTIPLE) for length in picture.shape[1::-1]]
        shift = [(size[k] - scale * picture.shape[1 - k]) / 2 + (scale - 1) / 2 for k in range(2)]
        matrix = np.array([[scale, 0, shift[0]], [0, scale, shift[1]]])
        window = cut_window(picture, matrix, (size[0], size[1]))
        cells, chances = detector.search(window)
        candidates += _peaks(cells, matrix, scale, settings.start)
        glances.append(WindowRegions.of(chances, matrix, detector))
    return without_doubles(candidates, settings.alike)[: settings.most], glances


def _peaks(cells: FaceCells, matrix: np.ndarray, scale: float, start: float) -> list[Candidate]:
    """Cells that are higher than their neighbours, as frames in the picture."""
    from scipy.ndimage import maximum_filter

    grid = cells.score.reshape(cells.cell[-1] + 1)
    highest = maximum_filter(grid, 3).ravel()
    chosen = np.flatnonzero((cells.score >= highest) & (cells.score > start))
    centres = (cells.centre - matrix[:, 2]) / scale
    return [
        Candidate(FaceFrame(centres[k], float(cells.side[k] / scale), float(cells.roll[k])), float(cells.score[k]))
        for k in chosen
    ]


def without_doubles(candidates: list[Candidate], overlap: float) -> list[Candidate]:
    """The best of those whose frames overlap by more, the best first."""
    kept: list[Candidate] = []
    for candidate in sorted(candidates, key=lambda one: -one.score):
        if all(frames_overlap(candidate.frame, other.frame) <= overlap for other in kept):
            kept.append(candidate)
    return kept


def common_share(first: FaceFrame, second: FaceFrame) -> float:
    """Share of the smaller of two frames that the other has, as if they were upright."""
    return _common(first, second) / max(min(first.side, second.side) ** 2, _LEAST)


def frames_overlap(first: FaceFrame, second: FaceFrame) -> float:
    """Intersection over union of two frames, as if they were upright."""
    common = _common(first, second)
    return common / max(first.side**2 + second.side**2 - common, _LEAST)


def _common(first: FaceFrame, second: FaceFrame) -> float:
    """Area that two frames have in common."""
    low = np.maximum(first.centre - first.side / 2, second.centre - second.side / 2)
    high = np.minimum(first.centre + first.side / 2, second.centre + second.side / 2)
    return float(np.prod(np.maximum(high - low, 0)))
