"""How far an eye is open."""

import numpy as np


def eye_openness(ring: np.ndarray) -> float:
    """Height of an eye for its width, by landmarks (6, 2 or 3) around it from one corner on."""
    corner, above, over, other, under, below = ring
    height = (np.linalg.norm(above - below) + np.linalg.norm(over - under)) / 2
    return float(height / np.maximum(np.linalg.norm(corner - other), 1e-12))
