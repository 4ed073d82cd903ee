"""A few points of a part that speak for those around them."""

from collections.abc import Callable

import numpy as np


class Guides:
    """Points of a part, one of which is near each: a wall far from it is far from those that it speaks for.

    guides: (G,) ids of those points. of: (W,) the one of them that speaks for each point of the part.
    """

    def __init__(self, shape: np.ndarray, reach: float) -> None:
        """shape: (W, 3) metres. reach: metres, how far from each point there is one that speaks for it."""
        nearest = np.full(len(shape), -1)
        distance = np.full(len(shape), np.inf)
        while (distance > reach).any():
            guide = int((distance > reach).argmax())
            away = np.linalg.norm(shape - shape[guide], axis=1)
            nearest[away < distance] = guide
            distance = np.minimum(distance, away)
        self.guides, self.of = np.unique(nearest, return_inverse=True)

    def near(self, shape: np.ndarray, margin: float, distance: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Ids of points of the part (W, 3) that may be nearer to a wall than so many metres.

        distance: of points (M, 3) from the wall, negative in it.
        """
        guides = shape[self.guides]
        away = np.linalg.norm(shape - guides[self.of], axis=1)
        return np.flatnonzero(distance(guides)[self.of] - away < margin)
