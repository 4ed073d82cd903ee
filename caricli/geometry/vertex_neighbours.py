"""Which vertices share an edge."""

import numpy as np
import scipy.sparse as sp


def vertex_neighbours(faces: np.ndarray, count: int) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Adjacency of the vertices of a mesh, and the operator that takes the mean of every vertex's neighbours.

    faces: (F, 3). count: V; every vertex is in a triangle.
    Returns (adjacency (V, V) of ones, mean (V, V) whose rows sum to one), sparse.
    """
    corners = np.concatenate([faces, np.roll(faces, 1, axis=1)]).ravel()
    others = np.concatenate([np.roll(faces, 1, axis=1), faces]).ravel()
    adjacency = (sp.csr_matrix((np.ones(len(corners)), (corners, others)), (count, count)) > 0).astype(float)
    return adjacency, sp.diags(1 / np.asarray(adjacency.sum(1)).ravel()) @ adjacency
