"""Mouth and eyes that open or close: whether what is between lips and lids can be taken from the old picture."""

import cv2
import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.methods.redraw.original import Original
from caricli.methods.redraw.view import View
from caricli.structures.landmarks import MOUTH_CORNERS

_CLOSED_MOUTH = 1.6e-3
"""Of the square of the head's height: a mouth of so little area is closed."""

_CLOSED_EYE = 3e-4
"""The same of an eye."""

_OPENS = (1.35, 1.7)
"""Growth of a mouth's area: up to the first what is in it stretches, from the second on it is drawn anew."""

_CLOSES = (0.6, 0.25)
"""The same of one that closes, and of eyes: from the second on skin takes nothing that was between lips or lids."""

_SEAM = (0.02, 0.03)
"""Of the mouth's width: an opening that has become thinner than the first shows no drawn teeth, only a line; from the
second on it shows all."""


def drawn_anew(original: Original, view: View) -> np.ndarray:
    """(W,) from 0 to 1 for vertices in and around mouth and eyes: how far what is between lips and lids is another
    thing than the old picture shows there; zero elsewhere.
    """
    anew = np.zeros(len(original.rig.neutral))
    now, before = _areas(original, view, original.wall, _CLOSED_MOUTH)
    # A drawn mouth may be open where the fitted one is hardly so: then it stretches.
    share = max(
        smooth_step(now / max(before, float(original.mouth.sum())), *_OPENS), smooth_step(now / before, *_CLOSES)
    )
    anew[original.wall > 0] = 0 if original.rows else share
    anew[: len(original.template.vertices)][original.template.mask("mouth", "lips", "inner_mouth")] = share
    for name, eye in original.eyes.items():
        now, before = _areas(original, view, eye, _CLOSED_EYE)
        lids = original.lids[name]
        anew[lids] = np.maximum(anew[lids], smooth_step(now / before, *_CLOSES))
    return anew


def _areas(original: Original, view: View, inside: np.ndarray, least: float) -> list[float]:
    """Samples of an opening now and in the old picture, a few more.

    inside: (W,) 1 at vertices that it shows. least: of the square of the head's height, area of these few.
    """
    more = least * (original.size * view.window.fine) ** 2
    return [float((seen.carried(inside[:, None]) > 0.5).sum()) + more for seen in (view, original.view)]


def seams(original: Original, view: View) -> np.ndarray:
    """(H, W) float32 from 0 to 1: how far samples are in a mouth that has closed to a seam; none where it was one."""
    ids = original.template.annotation.landmarks[[corner[0] for corner in MOUTH_CORNERS]]
    right, left = view.placed[ids, :2]
    width = max(float(np.linalg.norm(left - right)) * view.window.fine, 1.0)
    before = smooth_step(float(_thickness(original.view.inside, width).max()), *_SEAM)
    seam: np.ndarray = before * view.inside * smooth_step(_thickness(view.inside, width), *_SEAM[::-1])
    return seam.astype(np.float32)


def _thickness(inside: np.ndarray, width: float) -> np.ndarray:
    """(H, W) how thick an opening (H, W) bool is around each sample, as far as it counts. width: samples of a unit."""
    # A distance is to the middle of the next sample: half of one is in the opening.
    half = cv2.distanceTransform(inside.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) - 0.5
    across = 2 * int(np.ceil(_SEAM[1] * width)) + 1
    thickest = cv2.dilate(half, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (across, across)))
    return 2 * thickest / width
