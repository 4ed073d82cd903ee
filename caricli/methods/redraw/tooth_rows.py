"""What a picture shows in a mouth, in two parts: what goes with the skull, and what goes with the lower jaw."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.redraw.original import Original
from caricli.structures import Material

_BINS = 40  # from the upper lip to the lower one
_HIGH = 0.5  # of the height of the mouth where it is highest: where it is less, its corners are
_BITE = (0.35, 0.8)  # from the upper lip to the lower one, between which upper teeth end
_DARK = 0.8  # of the usual brightness in a mouth: a gap between teeth is darker


@dataclass(frozen=True, eq=False)
class ToothRows:
    """The teeth of an Original whose mouth is open in the picture.

    upper, lower: ids of vertices of the head's own. below: (H, W) float32, 1 where samples of the old picture show what
    is below the upper teeth, 0 elsewhere.
    """

    upper: np.ndarray
    lower: np.ndarray
    below: np.ndarray

    @classmethod
    def of(cls, original: Original) -> "ToothRows | None":
        """Those of an Original, or None where its head has none, or the picture shows no open mouth."""
        teeth = np.unique(original.rig.faces[original.rig.triangle_materials == Material.TEETH])
        if not len(teeth) or not original.is_open:
            return None
        heights = _above_arch(original.rig.neutral[teeth])
        return cls(teeth[heights > 0], teeth[heights <= 0], _below(original))


def _above_arch(teeth: np.ndarray) -> np.ndarray:
    """(N,) heights of vertices (N, 3) of teeth above the surface that lies between both rows."""
    x, y, z = teeth.T
    terms = np.column_stack([np.ones(len(teeth)), z, x**2])
    return y - terms @ np.linalg.lstsq(terms, y, rcond=None)[0]


def _below(original: Original) -> np.ndarray:
    """(H, W) float32, 1 where samples of the mouth are below its darkest line, or below it all where none is dark."""
    mouth = original.mouth
    rows = np.arange(len(mouth))[:, None]
    top = np.where(mouth, rows, len(mouth)).min(0)
    height = np.where(mouth, rows, -1).max(0) + 1 - top
    share = (rows - top) / np.maximum(height, 1)
    middle = mouth & (height >= _HIGH * height.max())
    bright = original.window.sampled(original.picture).mean(2)[middle]
    bins = np.minimum((share[middle] * _BINS).astype(int), _BINS - 1)
    samples = np.bincount(bins, minlength=_BINS)
    # In a low mouth there are heights of which there is nothing, and that is not dark.
    profile = np.where(samples > 0, np.bincount(bins, bright, _BINS) / np.maximum(samples, 1), np.inf)
    first = int(_BITE[0] * _BINS)
    last = int(_BITE[1] * _BINS)
    darkest = first + int(profile[first:last].argmin())
    gap = darkest / _BINS if profile[darkest] < _DARK * np.median(bright) else 1.0
    return ((share > gap) & (height > 0)).astype(np.float32)
