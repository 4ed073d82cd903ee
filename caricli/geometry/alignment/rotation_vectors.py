"""Rotations as vectors along their axes, as long as their angles.

As `scipy.spatial.transform` has them, whose import takes as long as a thousand of these.
"""

import numpy as np


def rotation_vectors(matrices: np.ndarray) -> np.ndarray:
    """Rotation matrices (..., 3, 3) to vectors (..., 3) in radians, none longer than pi."""
    m = matrices.reshape(-1, 3, 3)
    # The products of a quaternion (x, y, z, w) with itself, times four: every row of them is along it (Shepperd 1978),
    # and the one with the largest diagonal exactly so.
    products = np.empty((len(m), 4, 4))
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        products[:, i, i] = 1 + 2 * m[:, i, i] - trace
        products[:, i, j] = products[:, j, i] = m[:, i, j] + m[:, j, i]
        products[:, i, 3] = products[:, 3, i] = m[:, k, j] - m[:, j, k]
    products[:, 3, 3] = 1 + trace
    best = np.diagonal(products, axis1=1, axis2=2).argmax(1)
    quaternions = products[np.arange(len(m)), best]
    quaternions *= np.where(quaternions[:, 3:] < 0, -1, 1)
    axes = quaternions[:, :3]
    sines = np.sqrt((axes**2).sum(1))
    turned = sines > 0
    angles = 2 * np.arctan2(sines, quaternions[:, 3])
    vectors = axes * np.divide(angles, sines, out=np.zeros(len(m)), where=turned)[:, None]
    return vectors.reshape(*matrices.shape[:-2], 3)


def rotation_matrices(vectors: np.ndarray) -> np.ndarray:
    """Rotation vectors (..., 3) in radians to matrices (..., 3, 3)."""
    v = vectors.reshape(-1, 3)
    half = np.sqrt((v**2).sum(1)) / 2
    x, y, z = (v * (np.sinc(half / np.pi) / 2)[:, None]).T
    w = np.cos(half)
    matrices = np.empty((len(v), 3, 3))
    matrices[:, 0, 0] = 1 - 2 * (y * y + z * z)
    matrices[:, 1, 1] = 1 - 2 * (x * x + z * z)
    matrices[:, 2, 2] = 1 - 2 * (x * x + y * y)
    matrices[:, 0, 1] = 2 * (x * y - z * w)
    matrices[:, 1, 0] = 2 * (x * y + z * w)
    matrices[:, 0, 2] = 2 * (x * z + y * w)
    matrices[:, 2, 0] = 2 * (x * z - y * w)
    matrices[:, 1, 2] = 2 * (y * z - x * w)
    matrices[:, 2, 1] = 2 * (y * z + x * w)
    return matrices.reshape(*vectors.shape, 3)
