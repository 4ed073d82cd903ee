"""What a network reads in a sketch; light to import, which networks are not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from caricli.structures.sketch import Sketch


@dataclass(frozen=True, eq=False)
class StrokesRead:
    """What a network reads in a sketch.

    sketch: Sketch whose strokes have the names that are read, cut where what they draw changes. chances: (S, C) from 0
    to 1 that its strokes draw curves, means along them. curves: C names.
    """

    sketch: Sketch
    chances: np.ndarray
    curves: tuple[str, ...]


Read = Callable[[Sketch, Sequence[int]], StrokesRead]
"""What tells what a network reads in a sketch, some strokes of which stay whole, as ``read_strokes`` does."""
