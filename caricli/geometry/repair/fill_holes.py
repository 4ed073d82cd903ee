"""Close the holes of a disc, so that what surrounds them cannot fold into them."""

import igl
import numpy as np


def fill_holes(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Put a fan of triangles into every boundary loop but the longest.

    vertices: (V, 3). faces: (F, 3), a disc with H holes, counter-clockwise from outside.
    Returns vertices (V + H, 3), the middles of the holes last, faces (F + G, 3), the fans last, and the loop (L,) that
    is left, counter-clockwise.
    """
    loops = igl.boundary_loop_all(np.asarray(faces, np.int64))
    # Longest by length, not by count: the edges around an eye are many and short.
    rings = [np.asarray(loop) for loop in loops]
    lengths = [np.linalg.norm(vertices[ring] - vertices[np.roll(ring, -1)], axis=1).sum() for ring in rings]
    outer = rings.pop(int(np.argmax(lengths)))
    fans = [np.column_stack([np.roll(ring, -1), ring, 0 * ring + len(vertices) + k]) for k, ring in enumerate(rings)]
    middles = [vertices[ring].mean(0, keepdims=True) for ring in rings]
    return np.concatenate([vertices, *middles]), np.concatenate([faces, *fans]), outer
