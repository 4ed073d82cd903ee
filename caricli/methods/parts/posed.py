"""A face and its expressions, to which parts are fitted."""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True, eq=False)
class Posed:
    """The skin of a face and its expressions.

    neutral: (V, 3) metres. names: K. deltas: (K, V, 3) metres. given: (V, 3) metres, the face with the expression that
    the neutral one was found from, or None. teeth: (2,) metres, of a Face, or None.
    """

    neutral: np.ndarray
    names: tuple[str, ...]
    deltas: np.ndarray
    given: np.ndarray | None = None
    teeth: np.ndarray | None = None

    def only(self, k: int) -> "Posed":
        """With expression k alone."""
        return replace(self, names=self.names[k : k + 1], deltas=self.deltas[k : k + 1])
