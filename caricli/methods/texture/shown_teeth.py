"""How far a picture shows teeth."""

import cv2
import numpy as np

from caricli.methods.parts.incisors import lip_middles
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.structures import Face
from caricli.structures.landmarks import LIP_PAIRS
from caricli.structures.parsing import Region
from caricli.template.template import Template

_BEYOND = 0.25  # of the way between lips, how far beyond both is looked, since landmarks are not exact
_STEPS = 96  # on that way
_OPEN = 2.5  # pixels between lips: with fewer a picture says nothing of teeth
_SEEN = 0.3  # of the way between lips, what has to show the inside of a mouth
_GAP = 0.1  # of the mouth's height: what is not wider between teeth, or below them, is a line or a speck
_UPPER = 0.5  # of the mouth's height: a single row that begins higher is of upper teeth


def shown_teeth(face: Face, head: Template, regions: np.ndarray) -> np.ndarray | None:
    """Lengths (2,) of teeth that a picture shows below the upper lip and above the lower one, metres.

    Between lips its regions show teeth, the dark of the mouth, and teeth again, or some of these: what counts are
    shares of the way from lip to lip, of the three pairs of landmarks the middle one, times the way between the face's
    own lips. A dark line between lip and teeth is the lip's shadow, one between teeth tells no rows apart, and one row
    is the upper one unless it begins far below its lip. Lower teeth stand on the lower lip, or are none.

    face: Face with landmarks. head: Template in its shape. regions: (H, W) values of Region.
    Returns None where the mouth is closed, or the template does not tell its lips.
    """
    lips = lip_middles(head)
    points = face.require_landmarks()
    shares = [row for row in (_row(regions, *points[list(pair)]) for pair in LIP_PAIRS) if row is not None]
    if not shares or lips is None:
        return None
    upper, lower = head.vertices[lips]
    return np.median(shares, axis=0) * np.linalg.norm(upper - lower)


def _row(regions: np.ndarray, upper: np.ndarray, lower: np.ndarray) -> tuple[float, float] | None:
    """Shares of the way between two points (2,) of lips that teeth take at either end, None of a closed mouth."""
    way = np.linspace(-_BEYOND, 1 + _BEYOND, _STEPS)
    across = lower - upper
    x, y = (upper + way[:, None] * across).T
    labels = sample_pixels(regions, x, y, cv2.INTER_NEAREST)
    inside = np.flatnonzero(np.isin(labels, (Region.MOUTH, Region.TEETH)))
    if np.linalg.norm(across) < _OPEN or len(inside) < _SEEN * _STEPS / (1 + 2 * _BEYOND):
        return None
    teeth = labels[inside[0] : inside[-1] + 1] == Region.TEETH
    places = np.flatnonzero(teeth)
    if not len(places):
        return 0.0, 0.0
    narrow = _GAP * len(teeth)
    gaps = np.diff(places) - 1
    if gaps.max(initial=0) > narrow:
        # The widest gap is that between both rows.
        last = int(gaps.argmax())
        rows = (places[last] + 1) / len(teeth), 1 - places[last + 1] / len(teeth)
    elif places[0] < _UPPER * len(teeth):
        return (places[-1] + 1) / len(teeth), 0.0
    else:
        rows = 0.0, 1 - places[0] / len(teeth)
    return rows if len(teeth) - 1 - places[-1] <= narrow else (rows[0], 0.0)
