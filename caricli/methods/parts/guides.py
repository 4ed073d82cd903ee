"""A few points of a part that speak for those around them."""

from collections.abc import Callable

import numpy as np


class Guides:
    """Points of a part, one of which is near each: a wall far from it is far from those that it speaks for."""

    def __init__(self, shape: np.ndarray, reach: float) -> None:
        """shape: (W, 3) metres. reach: metres, how far from each point there is one that speaks for it."""
        self.of = np.full(len(shape), -1)
        distance = np.full(len(shape), np.inf)
        while (distance > reach).any():
            guide = int((distance > reach).argmax())
            away = np.linalg.norm(shape - shape[guide], axis=1)
            self.of[away < distance] = guide
            distance = np.minimum(distance, away)

    def near(self, shape: np.ndarray, margin: float, distance: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Ids of points of the part (W, 3) that may be nearer to a wall than so many metres.

        distance: of points (M, 3) from the wall, negative in it.
        """
        guides, of = np.unique(self.of, return_inverse=True)
        away = np.linalg.norm(shape - shape[guides][of], axis=1)
        return np.flatnonzero(distance(shape[guides])[of] - away < margin)
