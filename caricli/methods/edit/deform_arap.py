"""As-rigid-as-possible deformation of the same handles, for comparison (deformable paper, supplement 7)."""

import igl
import numpy as np

from caricli.errors import NumericsError
from caricli.geometry.repair.components import mesh_components

_STEPS = 50
"""Alternations of rotations and positions; the shape has settled by then."""


def deform_arap(vertices: np.ndarray, faces: np.ndarray, handles: np.ndarray, displacements: np.ndarray) -> np.ndarray:
    """Move handles so that every one-ring stays as rigid as it can (Sorkine and Alexa 2007), by libigl.

    Components without handles are taken along by the largest one, unturned.

    vertices: (V, 3). faces: (F, 3). handles: (H,) vertex ids. displacements: (H, 3).
    Returns (V, 3). Raises NumericsError when the result is not finite.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    components = mesh_components(vertices, faces)
    handles = np.asarray(handles)
    moved = np.zeros_like(vertices)
    pulled = np.unique(components.labels[handles])
    for part in pulled:
        ids = np.flatnonzero(components.labels == part)
        own = np.searchsorted(ids, faces[components.labels[faces[:, 0]] == part])
        asked = components.labels[handles] == part
        goals = vertices[handles[asked]] + displacements[asked]
        moved[ids] = _deformed(vertices[ids], own, np.searchsorted(ids, handles[asked]), goals) - vertices[ids]
    carried = components.carry(moved)
    return vertices + np.where(np.isin(components.labels, pulled)[:, None], moved, carried)


def _deformed(vertices: np.ndarray, faces: np.ndarray, handles: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """One component (V, 3) with handles (H,) at their goals (H, 3)."""
    data = igl.ARAPData()
    data.max_iter = _STEPS
    igl.arap_precomputation(vertices, faces.astype(np.int64), 3, handles.astype(np.int32), data)
    deformed = igl.arap_solve(goals, data, vertices)
    if not np.isfinite(deformed).all():
        raise NumericsError("as-rigid-as-possible deformation came to no finite shape")
    return deformed
