"""How vertices mix at places on their triangles."""

import numpy as np
import scipy.sparse as sp


def corner_mix(corners: np.ndarray, weights: np.ndarray, count: int) -> sp.csr_matrix:
    """(N, V) sparse: what the V vertices of a mesh have, at places on its triangles, as the pixels that one covers.

    corners: (N, 3) the vertices of the triangle at each place. weights: (N, 3) barycentric, whose type the result has.
    count: V. Entries stand in the order of the corners, and sums are taken in it.
    """
    ends = np.arange(0, corners.size + 1, 3, dtype=np.int32)
    return sp.csr_matrix((weights.ravel(), corners.ravel().astype(np.int32), ends), (len(corners), count))
