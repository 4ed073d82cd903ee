"""A flattened surface, the right way up."""

import numpy as np


def turn_upright(places: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """Places (V, 2) around their middle, turned so that up in the plane is up on the surface (V, 3)."""
    places = places - places.mean(0)
    x, y = (vertices[:, 1] - vertices[:, 1].mean()) @ places
    turn = np.array([[y, -x], [x, y]]) / np.hypot(x, y)
    return places @ turn.T
