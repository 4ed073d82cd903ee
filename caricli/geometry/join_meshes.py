"""Several meshes as one."""

from collections.abc import Sequence

import numpy as np

from caricli.structures import Mesh


def join_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """One mesh of the vertices, polygons and UVs of several, in their order.

    Where any has UVs all have: those of a mesh without lie in one place. meshes: at least one.
    Returns Mesh.
    """
    width = max(mesh.polygons.shape[1] for mesh in meshes)
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    polygons = [_shifted(mesh.polygons, start, width) for mesh, start in zip(meshes, starts, strict=False)]
    if all(mesh.uvs is None for mesh in meshes):
        return Mesh(vertices, np.concatenate(polygons))
    uvs = [np.zeros((1, 2)) if mesh.uvs is None else mesh.uvs for mesh in meshes]
    starts = np.cumsum([0, *(len(places) for places in uvs)])
    corners = [_shifted(_uv_polygons(mesh), start, width) for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(vertices, np.concatenate(polygons), np.concatenate(uvs), np.concatenate(corners))


def _uv_polygons(mesh: Mesh) -> np.ndarray:
    return np.where(mesh.polygons >= 0, 0, -1) if mesh.uv_polygons is None else mesh.uv_polygons


def _shifted(polygons: np.ndarray, start: int, width: int) -> np.ndarray:
    """Rows padded to a width, their indices counted from ``start``."""
    wide = np.pad(polygons, ((0, 0), (0, width - polygons.shape[1])), constant_values=-1)
    return np.where(wide >= 0, wide + start, -1).astype(np.int32)
