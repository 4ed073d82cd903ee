"""Where lines of a face usually run: points (M, 2) across and up, in widths of the face between the eyes.

Every function takes the 68 landmarks (68, 2), and the side where there are two: -1 is the subject's right, 1 the left.
"""

import numpy as np

from caricli.structures.landmarks import BROWS, JAW, LIPS, LOWER_LID, LOWER_LIP, POINT_NAMES, UPPER_LIP

_STEPS = 40  # points of a line
_OUTER = {-1: POINT_NAMES["eye_outer_right"], 1: POINT_NAMES["eye_outer_left"]}
_LOWER = {-1: LOWER_LID["right"][::-1], 1: LOWER_LID["left"][::-1]}
_WING = {-1: POINT_NAMES["nostril_right"], 1: POINT_NAMES["nostril_left"]}
_CORNER = {-1: POINT_NAMES["mouth_corner_right"], 1: POINT_NAMES["mouth_corner_left"]}
_JAW = {-1: JAW[6], 1: JAW[10]}


def usual_lines(marks: np.ndarray) -> list[np.ndarray]:
    """The lines that age leaves in nearly every face."""
    lines = [forehead_line(marks, rise) for rise in (0.12, 0.24, 0.36)]
    lines += [frown_line(marks, side) for side in (-1, 1)]
    for side in (-1, 1):
        lines += [smile_fold(marks, side), corner_fold(marks, side)]
        lines += [crow_line(marks, side, rise) for rise in (0.1, 0.0, -0.1)]
        lines.append(bag_line(marks, side, 0.0))
    return lines


def forehead_line(marks: np.ndarray, rise: float) -> np.ndarray:
    """A line across the forehead. rise: above the brows."""
    height = marks[BROWS, 1].max() + rise
    return curve([-0.5, height], [0, height + 0.06], [0.5, height])


def frown_line(marks: np.ndarray, side: int) -> np.ndarray:
    """The upright line between the brows that a frown draws."""
    brow = marks[BROWS, 1].max()
    x = 0.06 * side
    return curve([x, brow + 0.02], [1.2 * x, brow - 0.08], [x, brow - 0.2])


def root_line(marks: np.ndarray, rise: float) -> np.ndarray:
    """A line across the root of the nose. rise: above it."""
    root = marks[POINT_NAMES["nose_root"], 1] + rise
    return curve([-0.09, root], [0, root - 0.02], [0.09, root])


def smile_fold(marks: np.ndarray, side: int, out: float = 0.0) -> np.ndarray:
    """The fold from the wing of the nose past the corner of the mouth. out: farther out in the cheek."""
    wing = marks[_WING[side]]
    corner = marks[_CORNER[side]]
    start = wing + [(0.05 + out) * side, -0.4 * out]
    return curve(start, corner + [(0.17 + out) * side, 0.12], corner + [(0.12 + out) * side, -0.1])


def corner_fold(marks: np.ndarray, side: int) -> np.ndarray:
    """The fold from the corner of the mouth down to the jaw."""
    corner = marks[_CORNER[side]]
    end = (corner + 2 * marks[_JAW[side]]) / 3
    return curve(corner + [0.02 * side, 0], corner + [0.06 * side, -0.12], end)


def crow_line(marks: np.ndarray, side: int, rise: float) -> np.ndarray:
    """A crow's foot beside an eye. rise: how far it goes up."""
    outer = marks[_OUTER[side]]
    return curve(*(outer + [out * side, share * rise] for out, share in ((0.04, 0.25), (0.12, 0.5), (0.22, 1))))


def bag_line(marks: np.ndarray, side: int, drop: float) -> np.ndarray:
    """A line below an eye. drop: how much farther down than usual."""
    below = marks[list(_LOWER[side])] - [0, 0.09 + drop]
    return curve(below[0], below[1:3].mean(0) - [0, 0.05], below[3])


def bunny_line(marks: np.ndarray, side: int, share: float) -> np.ndarray:
    """A line down the side of the nose. share: from its root, 0, to its tip."""
    middle = (1 - share) * marks[POINT_NAMES["nose_root"]] + share * marks[POINT_NAMES["nose_tip"]]
    return curve(middle + [0.02 * side, 0.05], middle + [0.075 * side, 0.02], middle + [0.125 * side, -0.05])


def dimple(marks: np.ndarray, side: int) -> np.ndarray:
    """A dimple in the cheek."""
    corner = marks[_CORNER[side]]
    return curve(*(corner + [x * side, y] for x, y in ((0.15, 0.05), (0.16, 0.0), (0.15, -0.05))))


def chin_groove(marks: np.ndarray) -> np.ndarray:
    """The groove between lower lip and chin."""
    lip = marks[POINT_NAMES["lower_lip"], 1]
    height = 0.7 * lip + 0.3 * marks[POINT_NAMES["chin"], 1]
    return curve([-0.15, height - 0.03], [0, height + 0.02], [0.15, height - 0.03])


def chin_pit(marks: np.ndarray, across: float, share: float) -> np.ndarray:
    """A pit in the chin. across: from its middle. share: of the way from the lower lip down to its end."""
    height = (1 - share) * marks[POINT_NAMES["lower_lip"], 1] + share * marks[POINT_NAMES["chin"], 1]
    return curve([across - 0.006, height], [across, height + 0.003], [across + 0.006, height])


def lip_line(marks: np.ndarray, side: int, share: float, length: float) -> np.ndarray:
    """A short line out of the mouth. side: 1 above, -1 below. share: from the right corner, 0, to the left one.

    length: beyond the lip.
    """
    outline = marks[list(UPPER_LIP if side > 0 else LOWER_LIP)]
    at = np.array([np.interp(share, np.linspace(0, 1, 7), outline[:, k]) for k in (0, 1)])
    middle = marks[LIPS].mean(0)
    way = np.array([0.5 * (at[0] - middle[0]), 0.16 * side])
    way /= np.linalg.norm(way)
    return curve(at - 0.05 * way, at + 0.3 * length * way, at + length * way)


def curve(start: np.ndarray | list, middle: np.ndarray | list, end: np.ndarray | list) -> np.ndarray:
    """(M, 2) points of a parabola through three."""
    start, middle, end = (np.asarray(point, float) for point in (start, middle, end))
    t = np.linspace(0, 1, _STEPS)[:, None]
    return (1 - t) * (1 - 2 * t) * start + 4 * t * (1 - t) * middle + t * (2 * t - 1) * end
