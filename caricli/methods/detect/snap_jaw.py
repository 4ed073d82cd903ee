"""The jaw on the outline of the face, where the picture shows it before what is behind the head."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.geometry.lines.space_jaw import space_jaw
from caricli.structures.landmarks import COUNT, JAW, POINT_NAMES, Landmarks
from caricli.structures.parsing import Region

_FACE = (
    *(Region.SKIN, Region.BROWS, Region.EYES, Region.NOSE, Region.LIPS, Region.MOUTH, Region.TEETH, Region.BEARD),
    Region.GLASSES,
)


@dataclass(frozen=True)
class OutlineSettings:
    """When a jaw is looked for on the border of skin and background, and how far what is found counts.

    Lengths are shares of the landmarks' diagonal. reach: of the ways across the jaw on which the border is looked for;
    step: along them. inside: how far a head's landmarks are within that border. deviation: of the border that is seen
    from the outline. farthest: standard deviations of a landmark, from which on the border is another one's.
    alike: points along the jaw at which errors of landmarks still go together, as by a Gaussian. turned: logarithm of
    the ratio of a face's halves, as far as it is seen of either, from which on the jaw of the larger one is no outline.
    """

    reach: float = 0.1
    step: float = 1 / 400
    inside: float = 0.0045
    deviation: float = 0.01
    farthest: float = 2.0
    alike: float = 1.5
    turned: float = 0.1


_SETTINGS = OutlineSettings()


def snap_jaw(regions: np.ndarray, marks: Landmarks) -> Landmarks:
    """Move the landmarks of a jaw across it to where skin ends before the background.

    People mark a jaw on the outline that they see, and there it is the mesh's outline that has to be. The errors of
    the jaw's landmarks across it go together the more the nearer they are along it, so that those beside a border that
    is seen follow (the likeliest jaw by all borders, as of a Gaussian process).

    regions: (H, W) values of Region. marks: Landmarks with spreads, of a detector.
    Returns Landmarks, the jaw's at equal distances, or the same ones where no border is seen.
    """
    if marks.spreads is None or not marks.known[:COUNT].all():
        return marks
    jaw = marks.points[JAW]
    ways = _outwards(jaw)
    spreads = marks.spreads[JAW]
    deviations = np.sqrt(np.einsum("ka,kab,kb->k", ways, spreads, ways))
    gaps = _gaps(regions, jaw, ways, marks.diagonal)
    seen = _is_outline(marks.points) & (np.abs(gaps) < _SETTINGS.farthest * deviations)
    if not seen.any():
        return marks
    along = np.arange(len(jaw))
    alike = np.exp(-(((along[:, None] - along) / _SETTINGS.alike) ** 2) / 2)
    before = deviations[:, None] * alike * deviations
    doubt = np.eye(seen.sum()) * (_SETTINGS.deviation * marks.diagonal) ** 2
    gain = before[:, seen] @ np.linalg.inv(before[np.ix_(seen, seen)] + doubt)
    points = marks.points.copy()
    points[JAW] += (gain @ gaps[seen])[:, None] * ways
    told = np.einsum("ks,ks->k", gain, before[:, seen]) / deviations**2
    across = np.einsum("kab,kb->ka", spreads, ways) / deviations[:, None]
    surer = marks.spreads.copy()
    surer[JAW] -= told[:, None, None] * (across[:, :, None] * across[:, None])
    return replace(marks, points=space_jaw(points), spreads=surer)


def _outwards(jaw: np.ndarray) -> np.ndarray:
    """(17, 2) ways of length 1 across a jaw (17, 2), away from the face."""
    along = np.gradient(jaw, axis=0)
    ways = np.stack([-along[:, 1], along[:, 0]], 1)
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), np.finfo(float).tiny)
    return ways * np.sign((ways * (jaw - jaw.mean(0))).sum())


def _gaps(regions: np.ndarray, jaw: np.ndarray, ways: np.ndarray, diagonal: float) -> np.ndarray:
    """(17,) pixels along ways (17, 2) from a jaw (17, 2) to where it should be by the border; NaN where none is seen.

    The nearest border of the face counts, and only where it is one of skin and background.
    """
    steps = diagonal * np.arange(-_SETTINGS.reach, _SETTINGS.reach, _SETTINGS.step)
    columns, rows = np.moveaxis(np.rint(jaw[:, None] + steps[:, None] * ways[:, None]).astype(int), -1, 0)
    height, width = regions.shape
    within = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    shown = np.where(within, regions[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)], len(Region))
    face = np.isin(shown, _FACE)
    ends = face[:, :-1] & ~face[:, 1:]
    middles = (steps[:-1] + steps[1:]) / 2
    nearest = np.where(ends, np.abs(middles), np.inf).argmin(1)
    each = np.arange(len(jaw))
    skin = ends[each, nearest] & (shown[each, nearest] == Region.SKIN)
    plain = skin & (shown[each, nearest + 1] == Region.BACKGROUND)
    return np.where(plain, middles[nearest] - _SETTINGS.inside * diagonal, np.nan)


def _is_outline(points: np.ndarray) -> np.ndarray:
    """(17,) bool, landmarks of a jaw that are on the outline of a face with landmarks (L, 2), however it is turned."""
    chin = POINT_NAMES["chin"]
    ears = points[[JAW[1], JAW[-2]]]
    halves = np.log(np.maximum(np.linalg.norm(ears - points[POINT_NAMES["nose_tip"]], axis=1), np.finfo(float).tiny))
    larger = np.sign(chin - np.arange(len(JAW))) * (halves[0] - halves[1])
    larger[chin] = abs(halves[0] - halves[1])
    return larger < _SETTINGS.turned
