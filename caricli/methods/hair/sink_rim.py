"""Hair that ends under the skin, and stays there while the face moves."""

from dataclasses import replace

import igl
import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.structures import Hair, Mesh

_AT_ONCE = 2
"""Expressions: so many sink the skin together, as both brows do."""

_CLEAR = 0.0005
"""Metres that it stays under the skin, at least."""

_MOST = 0.005
"""Metres that it is sunk, at most: what a jaw uncovers would come out in the mouth."""


def sink_rim(hair: Hair, mesh: Mesh, deltas: np.ndarray) -> Hair:
    """The hair whose rim is so deep under the skin that expressions, which leave it where it is, do not uncover it.

    Of the skin nearest to a vertex counts how far it comes towards it, along its normal.
    hair: Hair on the face. mesh: Mesh of the face, metres. deltas: (K, V, 3) metres, what expressions do to it.
    Returns Hair; what is outside the skin stays.
    """
    points = hair.shell.vertices
    vertices, faces = np.ascontiguousarray(mesh.vertices, float), mesh.faces.astype(np.int64)
    _, triangle, nearest = igl.point_mesh_squared_distance(points, vertices, faces)
    normals = triangle_normals(vertices, faces[triangle])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(length > 0, length, 1)
    depth = ((nearest - points) * normals).sum(1)
    moves = np.asarray(deltas, float)[:, faces[triangle]]
    sinking = -np.einsum("khcx,hx->khc", moves, normals).min(2)
    wanted = np.sort(np.maximum(sinking, 0), axis=0)[-_AT_ONCE:].sum(0)
    more = np.where(depth > 0, np.clip(wanted + _CLEAR - depth, 0, _MOST), 0)
    more[wanted <= 0] = 0
    return replace(hair, shell=hair.shell.with_vertices(points - more[:, None] * normals))
