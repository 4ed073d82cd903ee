"""Lines that age and expressions draw into skin."""

import numpy as np
from scipy.spatial import cKDTree

from caricli.data.albedo import AlbedoPainter
from caricli.structures.landmarks import POINT_NAMES

_STEPS = 40  # points of a line


class WrinkleLines:
    """Distances of places on a head to the usual lines of a face, so that many faces share them.

    Lengths are in the painter's unit, the distance between the outer corners of the eyes.
    """

    def __init__(self, painter: AlbedoPainter) -> None:
        """painter: AlbedoPainter, whose places get wrinkles."""
        front = painter.places[:, 2] > painter.marks[[0, 16], 2].mean()
        lines = _lines(painter.marks[:, :2])
        distances = [cKDTree(line).query(painter.places[:, :2])[0] for line in lines]
        self.distances = [np.where(front, distance, np.inf) for distance in distances]

    def draw(self, generator: np.random.Generator) -> np.ndarray:
        """(P,) by how much skin is darker, factors up to 1: some of the lines, of random depth and width."""
        age = generator.uniform(0.1, 0.75)
        shade = np.ones(len(self.distances[0]))
        for distance in self.distances:
            depth = age * generator.uniform(0, 1) * (generator.random() < 0.7)
            width = generator.uniform(0.012, 0.035)
            shade *= 1 - depth * np.exp(-((distance / width) ** 2))
        return shade


def _lines(marks: np.ndarray) -> list[np.ndarray]:
    """Points (N, 2) along the lines, on a face with landmarks (68, 2)."""
    name = POINT_NAMES
    brow = marks[17:27, 1].max()
    lines = [_curve([-0.5, brow + k], [0, brow + k + 0.06], [0.5, brow + k]) for k in (0.12, 0.24, 0.36)]
    lines += [_curve([x, brow + 0.02], [1.2 * x, brow - 0.08], [x, brow - 0.2]) for x in (-0.06, 0.06)]
    for side, wing, corner, chin, outer, lower in (
        (-1, 31, 48, 6, name["eye_outer_right"], (36, 41, 40, 39)),
        (1, 35, 54, 10, name["eye_outer_left"], (45, 46, 47, 42)),
    ):
        out = np.array([side, 0.0])
        lines.append(
            _curve(marks[wing] + 0.05 * out, marks[corner] + [0.17 * side, 0.12], marks[corner] + [0.12 * side, -0.1])
        )
        lines.append(
            _curve(
                marks[corner] + 0.02 * out, marks[corner] + [0.06 * side, -0.12], (marks[corner] + 2 * marks[chin]) / 3
            )
        )
        lines += [
            _curve(
                marks[outer] + [0.04 * side, rise / 4],
                marks[outer] + [0.12 * side, rise / 2],
                marks[outer] + [0.22 * side, rise],
            )
            for rise in (0.1, 0.0, -0.1)
        ]
        below = marks[list(lower)] - [0, 0.09]
        lines.append(_curve(below[0], below[1:3].mean(0) - [0, 0.05], below[3]))
    return lines


def _curve(start: np.ndarray | list, middle: np.ndarray | list, end: np.ndarray | list) -> np.ndarray:
    """(N, 2) points of a parabola through three."""
    start, middle, end = (np.asarray(point, float) for point in (start, middle, end))
    t = np.linspace(0, 1, _STEPS)[:, None]
    return (1 - t) * (1 - 2 * t) * start + 4 * t * (1 - t) * middle + t * (2 * t - 1) * end
