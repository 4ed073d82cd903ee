"""Where in a window a detector's regions lie, told by pictures whose regions are true."""

import numpy as np

from caricli.data.evenly import evenly
from caricli.methods.train.detector.window_batch import Pictures
from caricli.models.detector.calibration import FARTHEST
from caricli.models.detector.config import HALF
from caricli.models.detector.model import Detector
from caricli.render.pixels.cut_window import cut_window
from caricli.structures.detection import FaceFrame

SHARE = 1.6
"""Side of the windows that are looked at, of the face's."""

SHIFTS = np.linspace(-FARTHEST, FARTHEST, 21)
"""Pixels of the window, right or down."""


def fit_region_shift(detector: Detector, pictures: Pictures, count: int) -> tuple[float, float]:
    """By how many pixels of a window the regions are to be shifted right and down to be most like the true ones.

    pictures: with truth, which it did not learn from. count: faces that are looked at. Each axis is told by itself: of
    SHIFTS the one with which true regions are likeliest in the mean.
    """
    size = (detector.size, detector.size)
    likely = np.zeros((2, len(SHIFTS)))
    for number, face in evenly(pictures.faces, count):
        picture = pictures.marked(number)
        matrix = FaceFrame.of(picture.landmarks[face]).matrix(detector.size, SHARE)
        chances = detector.parse(cut_window(picture.pixels, matrix, size))
        back = np.linalg.inv(np.vstack([matrix, [0, 0, 1]]))[:2]
        for axis, moves in enumerate(np.eye(2)):
            likely[axis] += [_likely(chances, picture.regions, back, shift * moves) for shift in SHIFTS]
    right, down = SHIFTS[likely.argmax(1)].round(6).tolist()
    return right, down


def _likely(chances: np.ndarray, regions: np.ndarray, back: np.ndarray, shift: np.ndarray) -> float:
    """Mean probability (h, w, R) of the true regions (H, W).

    back: (2, 3) map from the window's pixels to the picture's. shift: (2,) pixels of the window.
    """
    height, width = chances.shape[:2]
    rows, columns = np.mgrid[:height, :width]
    places = HALF * np.stack([columns, rows], -1) + shift
    there = np.rint(places @ back[:, :2].T + back[:, 2]).astype(int)
    x, y = there[..., 0], there[..., 1]
    height, width = regions.shape
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    return float(chances[rows[inside], columns[inside], regions[y[inside], x[inside]]].mean())
