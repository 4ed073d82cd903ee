"""Triangles that a deformation has turned over."""

import numpy as np

from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.triangle_normals import triangle_normals


def flipped_triangles(
    vertices: np.ndarray, gradients: DeformationGradients, some: np.ndarray | slice = slice(None)
) -> np.ndarray:
    """Triangles whose normal points away from where the map of their surroundings takes it.

    The surroundings are the one-rings of the triangle's corners: their mean linear map M takes the template's edges to
    an expected normal, ``M a x M b``; a triangle is flipped when its own normal has a negative product with it.

    vertices: (..., V, 3). gradients: DeformationGradients of the template. some: the triangles that are asked for, by
    numbers or as (F,) bool; all of them else.
    Returns (..., F) bool.
    """
    faces = gradients.faces[some]
    template = gradients.template
    maps = gradients.maps(vertices)
    around = sum(maps[..., faces[:, k], :, :] for k in range(3))
    a, b = (template[faces[:, k]] - template[faces[:, 0]] for k in (1, 2))
    expected = np.cross((around @ a[:, :, None])[..., 0], (around @ b[:, :, None])[..., 0])
    return (expected * triangle_normals(vertices, faces)).sum(-1) < 0
