"""The template's mesh at any resolution."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from caricli.geometry.subdivide import subdivide
from caricli.limits import MAX_VERTICES
from caricli.structures import Mesh


@dataclass(frozen=True, eq=False)
class FineMesh:
    """A mesh whose polygons were split.

    mesh: Mesh of W vertices, those of the coarse one first.
    weights: (W, V) sparse, of the coarse vertices.
    levels: how often polygons were split.
    """

    mesh: Mesh
    weights: sp.csr_matrix
    levels: int

    def with_vertices(self, vertices: np.ndarray) -> "FineMesh":
        """The same split mesh in another shape. vertices: (W, 3) metres."""
        return replace(self, mesh=self.mesh.with_vertices(vertices))

    def shaped(self, vertices: np.ndarray) -> "FineMesh":
        """The same split of a coarse shape (V, 3), what is between its vertices carried along linearly."""
        return self.with_vertices(self.weights @ vertices if self.levels else vertices)


def fine_mesh(template: Mesh, levels: int) -> FineMesh:
    """Subdivide a template's polygons and UVs.

    template: Mesh. levels: how often; 0 gives the template's own mesh.
    Returns FineMesh. Raises InputError beyond the cap on vertices or UVs, with which no file could be read back.
    """
    weights, polygons = subdivide(template.polygons, len(template.vertices), levels, MAX_VERTICES)
    uvs = template.uvs
    uv_polygons = template.uv_polygons
    if uvs is not None and uv_polygons is not None:
        uv_weights, uv_polygons = subdivide(uv_polygons, len(uvs), levels, MAX_VERTICES)
        uvs = uv_weights @ uvs
    return FineMesh(Mesh(weights @ template.vertices, polygons, uvs, uv_polygons), weights, levels)


def split_materials(materials: np.ndarray | None, polygons: np.ndarray, levels: int) -> np.ndarray | None:
    """Materials (Q,) of the polygons that ``fine_mesh`` makes of others.

    materials: (P,) of these, or None, which stays. polygons: (P, N), padded with -1. levels: how often they are split.
    """
    if materials is None or not levels:
        return materials
    quads = np.repeat(materials, (polygons >= 0).sum(1))
    return np.repeat(quads, 4 ** (levels - 1))
