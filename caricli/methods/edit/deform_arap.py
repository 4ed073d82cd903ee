"""As-rigid-as-possible deformation of the same handles, for comparison (deformable paper, supplement 7)."""

import igl
import numpy as np

from caricli.errors import NumericsError

_STEPS = 50
"""Alternations of rotations and positions; the shape has settled by then."""


def deform_arap(vertices: np.ndarray, faces: np.ndarray, handles: np.ndarray, displacements: np.ndarray) -> np.ndarray:
    """Move handles so that every one-ring stays as rigid as it can (Sorkine and Alexa 2007), by libigl.

    vertices: (V, 3). faces: (F, 3). handles: (H,) vertex ids. displacements: (H, 3).
    Returns (V, 3). Raises NumericsError when the result is not finite.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    data = igl.ARAPData()
    data.max_iter = _STEPS
    igl.arap_precomputation(vertices, np.asarray(faces, np.int64), 3, np.asarray(handles, np.int32), data)
    deformed = igl.arap_solve(vertices[handles] + displacements, data, vertices)
    if not np.isfinite(deformed).all():
        raise NumericsError("as-rigid-as-possible deformation came to no finite shape")
    return deformed
