"""A face and its expressions, to which parts are fitted."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from caricli.structures.arkit import Expressions


@dataclass(frozen=True, eq=False)
class Posed:
    """The skin of a face and its expressions.

    neutral: (V, 3) metres. expressions: K, of what actions they are made. deltas: (K, V, 3) metres. given: (V, 3)
    metres, the face with the expression that the neutral one was found from, or None. teeth: (2,) metres, of a Face, or
    None.
    """

    neutral: np.ndarray
    expressions: Expressions
    deltas: np.ndarray
    given: np.ndarray | None = None
    teeth: np.ndarray | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Of the expressions."""
        return tuple(self.expressions)

    @property
    def weights(self) -> tuple[Mapping[str, float], ...]:
        """(K,) of the actions that the expressions are made of, by name."""
        return tuple(self.expressions.values())

    def sized(self, times: float) -> "Posed":
        """So many times as large."""
        given = None if self.given is None else times * self.given
        teeth = None if self.teeth is None else times * self.teeth
        return Posed(times * self.neutral, self.expressions, times * self.deltas, given, teeth)

    def only(self, k: int) -> "Posed":
        """With expression k alone."""
        return replace(self, expressions={self.names[k]: self.weights[k]}, deltas=self.deltas[k : k + 1])
