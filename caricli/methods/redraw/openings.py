"""Mouth and eyes that open or close: whether what is between lips and lids can be taken from the old picture."""

import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.methods.redraw.original import Original
from caricli.methods.redraw.view import View

_CLOSED_MOUTH = 1.6e-3
"""Of the square of the head's height: a mouth of so little area is closed."""

_CLOSED_EYE = 3e-4
"""The same of an eye."""

_OPENS = (1.35, 1.7)
"""Growth of a mouth's area: up to the first what is in it stretches, from the second on it is drawn anew."""

_CLOSES = (0.6, 0.25)
"""The same of one that closes, and of eyes: from the second on skin takes nothing that was between lips or lids."""


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
