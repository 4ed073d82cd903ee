"""The vertices that a surface has."""

import numpy as np


def used_points(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(U, D) those of vertices (V, D) that are corners of faces (F, 3); all where there are no faces."""
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    return vertices[used] if len(faces) else vertices
