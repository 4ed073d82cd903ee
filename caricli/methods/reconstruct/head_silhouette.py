"""How far a head reaches above the brows in a picture, and what its forehead so is."""

import cv2
import numpy as np

from caricli.methods.reconstruct.picture_evidence import PictureEvidence
from caricli.methods.reconstruct.settings import SilhouetteSettings
from caricli.structures import Face
from caricli.structures.landmarks import BROWS, FOREHEAD, POINT_NAMES
from caricli.template.template import Template

_SETTINGS = SilhouetteSettings()


def find_forehead(
    face: Face, template: Template, points: np.ndarray, window: PictureEvidence
) -> tuple[np.ndarray, np.ndarray]:
    """Where the forehead of a face is, if its head, hair included, ends in the picture where it is seen to end.

    The head is cut out by its colours (GrabCut). Along the rays from the root of the nose through the forehead's
    landmarks the fitted head ends elsewhere; by a power of the middle one of these ratios, because hair is no skull,
    the forehead moves along its ray. Rays that do not agree say nothing.

    face: Face with the camera of the picture. template: of its topology. points: (68, 2) pixels.
    Returns (3, 2) pixels of the picture, and their confidence (3,), which is 0 where the root is unknown.
    """
    nothing = np.full((len(FOREHEAD), 2), np.nan), np.zeros(len(FOREHEAD))
    size = np.array(window.skin.shape[1::-1]) // 2
    covered = cv2.resize(window.covered.astype(np.uint8), size.tolist()) > 0
    marks = (window.to_window(points) + 0.5) / 2 - 0.5
    root = marks[POINT_NAMES["nose_root"]]
    if not np.isfinite(root).all():
        return nothing
    brow = int(np.clip(np.nanmin(marks[list(BROWS), 1], initial=size[1]), 0, size[1]))
    small = cv2.resize(window.lab, size.tolist(), interpolation=cv2.INTER_AREA)
    head = _cut(window, small, covered, brow)
    ids = template.annotation.landmarks[list(FOREHEAD)]
    fitted = (window.to_window(face.require_camera().project(face.vertices)) + 0.5) / 2 - 0.5 - root
    own = root + fitted[ids]
    steps = np.arange(*_SETTINGS.along)
    rays = root + steps[:, None] * (own - root)[:, None]
    ratios = np.array(
        [_end(head, small, ray, steps) / _reach(fitted, way) for ray, way in zip(rays, fitted[ids], strict=True)]
    )
    ratios = ratios[np.isfinite(ratios)]
    if len(ratios) < 2:
        return nothing
    ratio = np.clip(np.median(ratios), *_SETTINGS.limits)
    places = root + ratio**_SETTINGS.power * (own - root)
    sure = _SETTINGS.trust / (1 + (np.ptp(ratios) / _SETTINGS.vague) ** 2)
    return window.to_picture(2 * (places + 0.5) - 0.5), np.full(len(FOREHEAD), sure)


def _cut(window: PictureEvidence, small: np.ndarray, covered: np.ndarray, brow: int) -> np.ndarray:
    """(H, W) bool: the head in the window at half its size.

    small: (H, W, 3) uint8, colours. covered: (H, W) bool, by the fitted mesh. brow: row of the brows; above it, what is
    beside the head along the border is surely not the head.
    """
    height, width = covered.shape
    inside = cv2.resize(window.inside.astype(np.uint8), (width, height)) > 0
    labels = np.full(covered.shape, cv2.GC_PR_BGD, np.uint8)
    labels[:brow][covered[:brow]] = cv2.GC_PR_FGD
    frame = np.zeros(covered.shape, bool)
    frame[: _SETTINGS.frame] = ~covered.any(0)
    frame[:brow, : _SETTINGS.frame] = True
    frame[:brow, -_SETTINGS.frame :] = True
    labels[frame] = cv2.GC_BGD
    labels[inside] = cv2.GC_FGD
    if not frame.any() or not inside.any():
        return covered
    cv2.setRNGSeed(0)
    background, foreground = np.zeros((2, 1, 65))
    cv2.grabCut(small, labels, (0, 0, 0, 0), background, foreground, _SETTINGS.rounds)
    return np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD))


def _reach(points: np.ndarray, way: np.ndarray) -> float:
    """How far points (V, 2) go about a way (2,) from the origin, in its lengths; they may be outside the picture."""
    length = np.linalg.norm(way)
    along = points @ way / length
    aside = np.abs(points @ np.array([-way[1], way[0]]) / length)
    return float(along[aside <= _SETTINGS.wedge * along].max() / length)


def _end(mask: np.ndarray, colours: np.ndarray, ray: np.ndarray, steps: np.ndarray) -> float:
    """The first of steps (S,) along a ray (S, 2) that is off a mask (H, W), where colours (H, W, 3) change, too.

    NaN where it leaves the picture before.
    """
    column, row = np.rint(np.nan_to_num(ray, nan=-1)).astype(int).T
    within = (column > 0) & (column < mask.shape[1] - 1) & (row > 0) & (row < mask.shape[0] - 1)
    place = np.clip(row, 0, mask.shape[0] - 1), np.clip(column, 0, mask.shape[1] - 1)
    stop = int(np.argmax(~within | ~mask[place]))
    if not within[stop] or mask[place][stop]:
        return np.nan
    seen = colours[place].astype(float)
    before = seen[max(stop - _SETTINGS.sides, 0) : max(stop, 1)].mean(0)
    change = np.linalg.norm(seen[stop : stop + _SETTINGS.sides].mean(0) - before)
    return float(steps[stop]) if change >= _SETTINGS.change else np.nan
