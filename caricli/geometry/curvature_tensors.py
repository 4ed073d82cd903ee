"""How a mesh bends, in every direction at every vertex."""

import numpy as np

_LEAST_AREA = 1e-12
"""Of the mean: triangles with less say nothing."""


def curvature_tensors(vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Second fundamental forms of vertices, as matrices in the axes of space.

    In each triangle the form that explains the change of the normals along its edges best (least squares, Rusinkiewicz
    2004, "Estimating Curvatures and Their Derivatives on Triangle Meshes"); at a vertex the mean of its triangles', by
    area. The normal curvature in a tangent direction w is ``w @ tensor @ w / (w @ w)``, positive where the surface
    bulges outwards, 1/R on a sphere of radius R.

    vertices: (V, 3), metres. faces: (F, 3), counter-clockwise from outside. normals: (V, 3), unit length.
    Returns (V, 3, 3), 1/metre; zeros where a vertex has no triangle with an area.
    """
    corners = vertices[faces]
    edges = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
    changes = normals[faces][:, [2, 0, 1]] - normals[faces][:, [1, 2, 0]]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    good = area > _LEAST_AREA * max(area.mean(), np.finfo(float).tiny)
    first = edges[:, 0] / np.where(good, np.linalg.norm(edges[:, 0], axis=1), 1)[:, None]
    second = edges[:, 1] - (edges[:, 1] * first).sum(1, keepdims=True) * first
    second /= np.where(good, np.linalg.norm(second, axis=1), 1)[:, None]
    axes = np.stack([first, second], axis=1)
    down = axes.transpose(0, 2, 1)
    form = _forms(edges @ down, changes @ down, good)
    tensors = ((down @ form @ axes) * area[:, None, None]).reshape(-1, 9)
    at = faces.ravel()
    weight = np.bincount(at, np.repeat(np.where(good, area, 0), 3), len(vertices))
    weight = np.where(weight > 0, weight, 1)
    total = np.zeros((len(vertices), 9))
    for k, same in ((0, 0), (1, 3), (2, 6), (4, 4), (5, 7), (8, 8)):  # it is symmetric
        total[:, k] = total[:, same] = np.bincount(at, np.repeat(tensors[:, k], 3), len(vertices)) / weight
    return total.reshape(-1, 3, 3)


def _forms(flat: np.ndarray, turn: np.ndarray, good: np.ndarray) -> np.ndarray:
    """Symmetric (F, 2, 2) that take edges (F, 3, 2) best to the changes (F, 3, 2) of the normals along them."""
    # Unknown a, b, c of [[a, b], [b, c]]: rows (x, y, 0) and (0, x, y) for every edge, so the matrix is banded.
    xx, xy, yy = ((flat[..., i] * flat[..., j]).sum(1) for i, j in ((0, 0), (0, 1), (1, 1)))
    right = np.stack(
        [
            (flat[..., 0] * turn[..., 0]).sum(1),
            (flat[..., 1] * turn[..., 0] + flat[..., 0] * turn[..., 1]).sum(1),
            (flat[..., 1] * turn[..., 1]).sum(1),
        ],
        axis=1,
    )
    zero = np.zeros_like(xx)
    normal = np.stack([xx, xy, zero, xy, xx + yy, xy, zero, xy, yy], axis=1).reshape(-1, 3, 3)
    normal[~good] = np.eye(3)
    a, b, c = np.linalg.solve(normal, np.where(good[:, None], right, 0)[..., None])[..., 0].T
    return np.stack([a, b, b, c], axis=1).reshape(-1, 2, 2)
