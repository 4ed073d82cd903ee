"""The template's mesh at any resolution."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.geometry.subdivide import subdivide
from caricli.geometry.triangulate import triangulate
from caricli.limits import MAX_VERTICES


@dataclass(frozen=True)
class FineMesh:
    """levels; weights (W, V) of the template's vertices, which come first; the other fields as in Template."""

    levels: int
    weights: sp.csr_matrix
    faces: np.ndarray
    polygons: np.ndarray
    uvs: np.ndarray | None
    uv_polygons: np.ndarray | None


def fine_mesh(template, levels):
    """Subdivide a template's polygons and UVs.

    template: Template. levels: how often; 0 gives the template's own mesh.
    Returns FineMesh. Raises InputError beyond the cap on vertices or UVs, with which no file could be read back.
    """
    weights, polygons = subdivide(template.polygons, len(template.vertices), levels, MAX_VERTICES)
    uvs, uv_polygons = template.uvs, template.uv_polygons
    if uvs is not None:
        uv_weights, uv_polygons = subdivide(uv_polygons, len(uvs), levels, MAX_VERTICES)
        uvs = uv_weights @ uvs
    faces = triangulate(polygons) if levels else template.faces
    return FineMesh(levels, weights, faces, polygons, uvs, uv_polygons)
