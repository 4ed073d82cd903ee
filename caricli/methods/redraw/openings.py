"""Mouth and eyes that open or close: whether what is between lips and lids can be taken from the old picture."""

import numpy as np

from caricli.methods.redraw.original import Original
from caricli.methods.redraw.view import View
from caricli.render.paint import smooth_step

_CLOSED = 1.6e-3
"""Of the square of the head's height: an opening of so little area is closed."""

_OPENS = (1.35, 1.7)
"""Growth of a mouth's area: up to the first what is in it stretches, from the second on it is drawn anew."""

_CLOSES = (0.6, 0.25)
"""The same of one that closes, and of eyes: from the second on skin takes nothing that was between lips or lids."""


def drawn_anew(original: Original, view: View) -> np.ndarray:
    """(W,) from 0 to 1 for vertices in and around mouth and eyes: how far what is between lips and lids is another
    thing than the old picture shows there; zero elsewhere.
    """
    anew = np.zeros(len(original.rig.neutral))
    now, before = _areas(original, view, original.wall)
    # A drawn mouth may be open where the fitted one is hardly so: then it stretches.
    share = max(smooth_step(now / max(before, original.open_mouth), *_OPENS), smooth_step(now / before, *_CLOSES))
    anew[original.wall > 0] = share
    anew[: len(original.template.vertices)][original.template.mask("mouth", "lips", "inner_mouth")] = share
    for name, eye in original.eyes.items():
        now, before = _areas(original, view, eye)
        lids = np.flatnonzero(original.template.mask(name))
        anew[lids] = np.maximum(anew[lids], smooth_step(now / before, *_CLOSES))
    return anew


def _areas(original: Original, view: View, inside: np.ndarray) -> list[float]:
    """Samples of an opening now and in the old picture, a few more. inside: (W,) 1 at vertices that it shows."""
    closed = _CLOSED * (original.size * view.window.fine) ** 2
    return [float((seen.carried(inside[:, None]) > 0.5).sum()) + closed for seen in (view, original.view)]
