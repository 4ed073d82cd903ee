"""A disc in the plane without folds: where flattening starts."""

import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.vertex_neighbours import vertex_neighbours


def embed_disc(vertices: np.ndarray, faces: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Spread a disc over the unit disc: its border on the circle, every other vertex amid its neighbours.

    No triangle is turned over (Tutte 1963), however the surface is bent.

    vertices: (V, 3). faces: (F, 3), one loop of borders, no holes. loop: (L,) the border, counter-clockwise.
    Returns (V, 2).
    """
    steps = np.linalg.norm(vertices[loop] - vertices[np.roll(loop, 1)], axis=1)
    angles = 2 * np.pi * np.cumsum(steps) / steps.sum()
    places = np.zeros((len(vertices), 2))
    places[loop] = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    adjacency, _ = vertex_neighbours(faces, len(vertices))
    laplacian = (sp.diags(np.asarray(adjacency.sum(1)).ravel()) - adjacency).tocsr()
    free = np.setdiff1d(np.arange(len(vertices)), loop)
    pull = -laplacian[free][:, loop] @ places[loop]
    places[free] = Cholesky(laplacian[free][:, free]).solve(pull)
    return places
