"""Where the points of a curve lie along a line that was drawn for it."""

import numpy as np

from caricli.geometry.lines.arc_lengths import arc_lengths
from caricli.geometry.lines.line_nodes import line_nodes
from caricli.geometry.lines.match_line import match_line, resample
from caricli.geometry.lines.rows_at import rows_at
from caricli.methods.sketch.settings import CORNERED
from caricli.template.feature_curves import FeatureCurve

_SAMPLES = 24
"""Points of a line by which its direction is told."""
_GAP = 0.1
"""Of a line's length: ends of a closed line may be so far apart."""
_NEAR = 1 / 8
"""Of the points from the first landmark to the last: as near to these a line ends that goes from one to the other."""
_ALIKE = 0.25
"""Of a line's size: what is left of the distance from a curve without place and size, where it draws all of it."""
_OTHER = 0.06
"""The same, from which on its shape does not tell what of the curve is where."""


def match_curve(curve: FeatureCurve, own: np.ndarray, line: np.ndarray, alone: bool) -> np.ndarray:
    """Places of a curve's points along a line, in pixels.

    A line that was drawn through as many points as there are landmarks on the curve (``line_nodes``) has the landmarks
    there. On a jaw from ear to ear, and on lips, lids and brows of another shape than the curve's, they stand at equal
    distances, as they are marked by hand (iBUG; Sagonas et al. 2013); what lies between landmarks stays at its share
    of the way. All else is warped (``match_line``).

    own: (K, 2) of the curve. line: (N, 2), in any direction, of some length. alone: whether no other line was drawn
    for the curve.
    Returns (K, 2), NaN for points beyond the ends of the line.
    """
    if not curve.closed:
        return _along(curve, own, curve.marks, line, alone)
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    if np.linalg.norm(line[0] - line[-1]) < _GAP * length:
        return _around(own, line)
    # Open it where nothing was drawn: opposite of the middle of the line.
    ring = own[:-1]
    nearest = _nearest(ring, resample(line, _SAMPLES))
    middle = nearest[len(nearest) // 2]
    shift = (middle + len(ring) // 2) % len(ring)
    order = np.roll(np.arange(len(ring)), -shift)
    marks = (curve.marks - shift) % len(ring)
    places = np.full((len(own), 2), np.nan)
    marks = marks if (np.diff(marks) > 0).all() else marks[:0]
    places[order] = _along(curve, ring[order], marks, line, alone)
    places[-1] = places[0]
    return places


def _along(curve: FeatureCurve, own: np.ndarray, marks: np.ndarray, line: np.ndarray, alone: bool) -> np.ndarray:
    """``match_curve`` for points own (K, 2) of an open curve or one that is cut open. marks: (M,) landmarks on it."""
    cornered = curve.name.startswith(CORNERED)
    line = _same_way(own, line)
    if not alone or len(marks) < 3:
        return match_line(own, line, alone and cornered)
    nodes = line_nodes(line, len(marks))
    if nodes is not None:
        return _between(own, marks, line, np.interp(nodes, np.arange(len(line)), _shares(line)))
    even = np.linspace(0, 1, len(marks))
    if cornered and _unlike(own, line) > _OTHER:
        return _between(own, marks, line, even)
    places = match_line(own, line, cornered)
    if cornered or not (_ends_near(marks, places) or (not curve.closed and _part(own, marks, line))):
        return places
    return _between(own, marks, line, even)


def _ends_near(marks: np.ndarray, places: np.ndarray) -> bool:
    """Whether what is found on a line, places (K, 2), begins and ends near the first and the last landmark."""
    met = np.flatnonzero(np.isfinite(places).all(axis=1))
    return bool(np.abs(met[[0, -1]] - marks[[0, -1]]).max() <= _NEAR * (marks[-1] - marks[0]))


def _part(own: np.ndarray, marks: np.ndarray, line: np.ndarray) -> bool:
    """Whether a line's shape is far more that from the first to the last landmark than that of the whole curve."""
    part = _unlike(own[marks[0] : marks[-1] + 1], line)
    return part < min(_ALIKE, _unlike(own, line) / 2)


def _unlike(points: np.ndarray, line: np.ndarray) -> float:
    """What is left of the distance between two lines without place and size, of the size."""
    shapes = [resample(each, _SAMPLES) for each in (points, line)]
    centred = [shape - shape.mean(0) for shape in shapes]
    sizes = [float(np.sqrt((shape**2).sum())) for shape in centred]
    return float(np.linalg.norm(centred[0] / sizes[0] - centred[1] / sizes[1]))


def _between(own: np.ndarray, marks: np.ndarray, line: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """(K, 2) places of points own (K, 2) along a line on which those of marks (M,) stand at shares (M,) of its length;
    NaN for those before the first and after the last."""
    places = np.full(own.shape, np.nan)
    first, last = int(marks[0]), int(marks[-1])
    along = arc_lengths(own)
    wanted = np.interp(along[first : last + 1], along[marks], shares)
    drawn = _shares(line)
    places[first : last + 1] = rows_at(wanted, drawn, line)
    return places


def _shares(line: np.ndarray) -> np.ndarray:
    """(N,) of a line's length up to its points, 0 to 1."""
    along = arc_lengths(line)
    return along / along[-1]


def _nearest(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(N,) of the points the numbers that are nearest to those of a line (N, 2)."""
    return np.argmin(((points - line[:, None]) ** 2).sum(-1), axis=1)


def _same_way(own: np.ndarray, line: np.ndarray) -> np.ndarray:
    """A line in the direction of points own (K, 2)."""
    dense = resample(own, 4 * _SAMPLES - 3)
    way = resample(line, _SAMPLES)
    # Pieces are told by where they lie, all else by how they would meet.
    trend = np.sign(np.diff(_nearest(dense, way))).sum()
    centred = dense[::4] - dense[::4].mean(0)
    along = (centred * (way - way.mean(0))).sum() - (centred * (way[::-1] - way.mean(0))).sum()
    backwards = trend < 0 if abs(trend) > _SAMPLES // 2 else along < 0
    return line[::-1] if backwards else line


def _around(own: np.ndarray, line: np.ndarray) -> np.ndarray:
    """(K, 2) places of a closed curve own (K, 2) along a closed line.

    Where it begins is told by the boxes around both, so that nothing hangs on where the line does.
    """
    ring = _closed(line)
    if _area(ring) * _area(own) < 0:
        ring = ring[::-1]
    low = own.min(0)
    size = np.maximum(np.ptp(own, axis=0), 1e-9)
    guess = ring.min(0) + (own[0] - low) / size * np.ptp(ring, axis=0)
    return match_line(own, _cut(ring, guess), whole=True)


def _closed(line: np.ndarray) -> np.ndarray:
    """A line whose ends are near to each other as a ring, without what goes beyond its beginning."""
    dense = resample(line, 16 * _SAMPLES + 1)
    end = round(_GAP * len(dense))
    gaps = np.linalg.norm(dense[:end, None] - dense[-end:], axis=-1)
    first, last = np.unravel_index(gaps.argmin(), gaps.shape)
    ring = dense[first : len(dense) - end + last + 1]
    return np.concatenate([ring, ring[:1]])


def _cut(ring: np.ndarray, place: np.ndarray) -> np.ndarray:
    """A ring from where it is nearest to a place, and back to there."""
    way = np.diff(ring, axis=0)
    along = ((place - ring[:-1]) * way).sum(1) / np.maximum((way**2).sum(1), 1e-12)
    feet = ring[:-1] + np.clip(along, 0, 1)[:, None] * way
    k = int(np.linalg.norm(feet - place, axis=1).argmin())
    return np.concatenate([feet[k : k + 1], ring[k + 1 :], ring[1 : k + 1], feet[k : k + 1]])


def _area(ring: np.ndarray) -> float:
    """Twice the signed area within a closed line (N, 2)."""
    a, b = ring[:-1], ring[1:]
    return float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
