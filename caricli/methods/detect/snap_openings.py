"""Lips and lids on the borders of mouths and eyes that a picture shows wider open than landmarks say."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from caricli.methods.detect.cut_openings import FaceWindow
from caricli.render.pixels.inside_polygon import inside_polygon
from caricli.structures.landmarks import COUNT, EYE_LEFT, EYE_RIGHT, LIPS_INSIDE, MOUTH, Landmarks
from caricli.structures.parsing import Region

_INNER = {49: 61, 50: 61, 51: 62, 52: 63, 53: 63, 55: 65, 56: 65, 57: 66, 58: 67, 59: 67}
"""Of every landmark around the lips, its corners aside, the one inside of them that goes with it."""

_CORNERS = ((48, 60), (54, 64))
_LOWER = (55, 56, 57, 58, 59, 65, 66, 67)
_STEP = 0.25  # pixels, along the ways from an eye's middle


@dataclass(frozen=True)
class BorderSettings:
    """When lips and lids are looked for in the picture, and how far what is found counts.

    agree: intersection over union of the mouth between landmarks and that of the regions, from which on both are right.
    least: area of the latter for the former, from which on it says more. narrowest: width of the former, as a share of
    the window's side; narrower ones are seen from the side. gap: pixels of the window, between pieces of a lip.
    wider: area of an eye in the picture for that between landmarks, from which on these are asked; holds: share of the
    latter that it has, without which it is another thing. farthest: pixels of the window, from an eye's landmark.
    lids, lips: standard deviation of those that are found so, along each axis, as a share of the landmarks' diagonal.
    usual: area of an eye, as a share of the window's, that of 95 % of generated faces; of a larger one landmarks know
    less, and its border counts the more.
    """

    agree: float = 0.6
    least: float = 0.8
    narrowest: float = 0.1
    gap: int = 4
    wider: float = 1.2
    holds: float = 0.75
    farthest: float = 30.0
    lids: float = 0.012
    lips: float = 0.02
    usual: float = 0.0122


_SETTINGS = BorderSettings()


def snap_openings(image: np.ndarray, regions: np.ndarray, marks: Landmarks) -> Landmarks:
    """Move the landmarks of a mouth or an eye to where the picture shows it, where it is much larger than they say.

    Inside of the lips is the border of the mouth as regions and colours show it; outside the end of what is labelled
    lips there, or as far from the inside as before. Lids go to the border of the eye, away from its middle. Of both
    places each counts as it is sure: with covariances S of the landmark and T of the border the mean by S^-1 and T^-1
    is taken. An eye larger than usual ones is none that landmarks were learnt from: its border is all the surer.

    image: (H, W, 3) uint8. regions: (H, W) values of Region. marks: Landmarks with spreads.
    Returns Landmarks, the same ones where there is nothing to move.
    """
    if marks.spreads is None or not marks.known[:COUNT].all():
        return marks
    window = FaceWindow.of(image, regions, marks.points)
    points = marks.points[:COUNT] @ window.matrix[:, :2].T + window.matrix[:, 2]
    places, deviations = _snapped_eyes(window, points)
    mouth = _open_mouth(window, points)
    if mouth is not None:
        places = _on_border(places, mouth, window.labels == Region.LIPS)
    rows = np.flatnonzero((places != points).any(1))
    if not len(rows):
        return marks
    targets = (places[rows] - window.matrix[:, 2]) @ np.linalg.inv(window.matrix[:, :2]).T
    own = marks.spreads[rows]
    border = np.eye(2) * (marks.diagonal * deviations[rows, None, None]) ** 2
    shares = own @ np.linalg.inv(own + border)
    moved = marks.points.copy()
    moved[rows] += np.einsum("kab,kb->ka", shares, targets - moved[rows])
    spreads = marks.spreads.copy()
    joined = shares @ border
    spreads[rows] = (joined + joined.swapaxes(1, 2)) / 2
    return replace(marks, points=moved, spreads=spreads)


def _snapped_eyes(window: FaceWindow, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Landmarks (68, 2) of a window with those of eyes on the border of eyes that are much larger.

    And the standard deviations (68,) of all that are on a border, as shares of the landmarks' diagonal.
    """
    _, parts = cv2.connectedComponents(window.eyes().astype(np.uint8))
    places = points.copy()
    deviations = np.full(COUNT, _SETTINGS.lips)
    usual = _SETTINGS.usual * parts.size
    for eye in (list(EYE_RIGHT), list(EYE_LEFT)):
        told = inside_polygon(points[eye], parts.shape)
        own = np.bincount(parts[told & (parts > 0)], minlength=1)
        shown = parts == own.argmax()
        held = own.max() / max(told.sum(), 1)
        if own.max() and held > _SETTINGS.holds and shown.sum() > _SETTINGS.wider * told.sum():
            places[eye] = _away_from_middle(points[eye], shown)
            deviations[eye] = _SETTINGS.lids * min((usual / shown.sum()) ** 2, 1)
    return places, deviations


def _away_from_middle(points: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """Points (K, 2) moved along the ways from their middle to where what is shown (S, S) bool ends."""
    middle = points.mean(0)
    lengths = np.linalg.norm(points - middle, axis=1)
    steps = np.arange(0, lengths.max() + _SETTINGS.farthest, _STEP)
    ways = (points - middle) / np.maximum(lengths, 1e-9)[:, None]
    along = (middle + steps[:, None, None] * ways).astype(np.float32)
    there = cv2.remap(shown.astype(np.float32), along[..., 0], along[..., 1], cv2.INTER_LINEAR) > 0.5
    last = np.where(there.any(0), len(steps) - 1 - there[::-1].argmax(0), 0)
    ends = np.where(steps[last] < lengths + _SETTINGS.farthest, steps[last], lengths)
    return middle + np.where(there.any(0), ends, lengths)[:, None] * ways


def _open_mouth(window: FaceWindow, points: np.ndarray) -> np.ndarray | None:
    """(S, S) bool, the mouth in a window with landmarks (68, 2), where it shows a larger one than they do."""
    seed = _largest(window.labelled_mouth)
    told = inside_polygon(points[list(LIPS_INSIDE)], seed.shape)
    common = (seed & told).sum() / max((seed | told).sum(), 1)
    wide = points[64, 0] - points[60, 0] > _SETTINGS.narrowest * len(seed)
    if not wide or common > _SETTINGS.agree or seed.sum() < _SETTINGS.least * max(told.sum(), 1):
        return None
    return _largest(window.mouth(seed))


def _largest(mask: np.ndarray) -> np.ndarray:
    """The largest piece of a mask (S, S) bool."""
    count, parts, figures, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    return mask if count == 1 else parts == 1 + figures[1:, cv2.CC_STAT_AREA].argmax()


def _on_border(points: np.ndarray, mouth: np.ndarray, lips: np.ndarray) -> np.ndarray:
    """Landmarks (68, 2) of a window with those of the mouth on the border of a mouth (S, S) bool and its lips."""
    columns = np.flatnonzero(mouth.any(0))
    before = points[[60, 64], 0]
    after = np.array([min(before[0], columns[0]), max(before[1], columns[-1])])
    places = points.copy()
    places[list(MOUTH), 0] = np.interp(points[list(MOUTH), 0], before, after)
    for corner, x, old in zip((60, 64), after, before, strict=True):
        if x != old:
            places[corner, 1] = _ends(mouth, x).mean()
    for outer, inner in _CORNERS:
        places[outer] = points[outer] + places[inner] - points[inner]
    for inner in set(_INNER.values()):
        places[inner, 1] = _ends(mouth, places[inner, 0])[int(inner in _LOWER)]
    for outer, inner in _INNER.items():
        lower = outer in _LOWER
        begin = _ends(mouth, places[outer, 0])[int(lower)]
        end = _lip_end(mouth | lips, places[outer, 0], begin, 1 if lower else -1)
        places[outer, 1] = begin + (points[outer] - points[inner])[1] if end is None else end
    return places


def _ends(mouth: np.ndarray, x: float) -> np.ndarray:
    """(2,) first and last row of a mouth (S, S) bool in the column nearest to x that it has."""
    columns = np.flatnonzero(mouth.any(0))
    return np.flatnonzero(mouth[:, columns[np.abs(columns - x).argmin()]])[[0, -1]] + [-0.5, 0.5]


def _lip_end(lips: np.ndarray, x: float, begin: float, step: int) -> float | None:
    """The row where lips (S, S) bool end at x, going up or down from a row, or None where none begin there."""
    rows = np.flatnonzero(lips[:, int(np.clip(round(x), 0, len(lips) - 1))])
    ahead = rows[(rows - begin) * step > 0][::step]
    if not len(ahead) or abs(ahead[0] - begin) > _SETTINGS.gap:
        return None
    jumps = np.flatnonzero(np.abs(np.diff(ahead)) > _SETTINGS.gap)
    return float(ahead[jumps[0]] if len(jumps) else ahead[-1]) + step / 2
