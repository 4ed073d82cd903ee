"""Exaggeration by curvature: steep where the surface bends, calm where it is flat."""

from collections.abc import Sequence

import igl
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from caricli.errors import NumericsError
from caricli.geometry.repair.components import mesh_components

SMOOTHING = 2e-4
"""Of the surface's area: time of the diffusion that smooths the curvature, over about 8 mm of a head."""

MAX_LOG_WEIGHT = 1.2
"""Natural logarithm: no gradient is scaled by more than 11 times as much as another, or needles would grow."""

_LEAST_AREA = 1e-12  # of the mean; rounding gives a triangle of three points in line a little area
_LEAST_DENSITY = 1e-3  # curvature times area, of which a sphere has 4 pi: keeps the logarithm of flat places sane
_HOLD = 1e-9  # of the mean diagonal: makes the Poisson system definite, which knows no translation


def exaggerate_curvature(
    vertices: np.ndarray, faces: np.ndarray, exponents: Sequence[float], hold: np.ndarray | None = None
) -> np.ndarray:
    """Scale the coordinates' gradients by |Gaussian curvature|^gamma and solve the Poisson equation.

    Minimises ``integral |grad x' - w grad x|^2`` with ``w = |K|^gamma``, K smoothed over the surface and w of mean one
    (sketch paper section 4.1 after Sela et al. 2015 and Yu et al. 2004). All levels share one factorisation.

    vertices: (V, 3). faces: (F, 3). exponents: gammas, 0 (unchanged) to about 0.35. hold: (V,) in [0, 1], 1 where the
    surface keeps its gradients (eyes and mouth, where they are unstable).
    Returns (len(exponents), V, 3), centroids kept. Raises NumericsError for meshes with degenerate triangles or unused
    vertices.
    """
    vertices = np.asarray(vertices, dtype=np.float64)
    double_areas = igl.doublearea(vertices, faces)
    # Cotangents of triangles without area have no meaning.
    if not double_areas.min() > _LEAST_AREA * double_areas.mean() or len(np.unique(faces)) < len(vertices):
        raise NumericsError("curvature exaggeration needs triangles with an area, and every vertex in one")
    laplacian = -igl.cotmatrix(vertices, faces)
    mass = igl.massmatrix(vertices, faces).diagonal()
    density = _log_density(vertices, faces, laplacian, mass, hold)
    gradient = igl.grad(vertices, faces)
    areas = np.tile(double_areas / 2, 3)
    hangers = mesh_components(vertices, faces).hangers
    stiffness = laplacian.diagonal().mean()
    held = _HOLD * sp.identity(len(vertices)) + hangers.T @ hangers
    factor = splu((laplacian + stiffness * held).tocsc())
    slopes = gradient @ vertices
    results = []
    for exponent in exponents:
        weights = np.exp(np.clip(exponent * density, -MAX_LOG_WEIGHT, MAX_LOG_WEIGHT))
        weights /= weights @ mass / mass.sum()
        scaled = np.tile(weights[faces].mean(1), 3) * areas
        exaggerated = factor.solve(gradient.T @ (scaled[:, None] * slopes))
        results.append(exaggerated + vertices.mean(0) - exaggerated.mean(0))
    if not np.isfinite(results).all():
        raise NumericsError("curvature exaggeration did not stay finite")
    return np.array(results)


def _log_density(
    vertices: np.ndarray, faces: np.ndarray, laplacian: sp.csc_matrix, mass: np.ndarray, hold: np.ndarray | None
) -> np.ndarray:
    """Logarithms (V,) of the smoothed curvature, of mean 0, and 0 where the surface is held."""
    total = mass.sum()
    density = np.abs(igl.gaussian_curvature(vertices, faces)) / mass * total
    # The angle defect at the boundary is no curvature.
    boundary = np.zeros(len(vertices), dtype=bool)
    boundary[igl.boundary_facets(faces)[0].ravel()] = True
    density[boundary] = np.median(density)
    log_density = np.log(np.clip(density, _LEAST_DENSITY, None))
    smoother = splu((sp.diags(mass) + SMOOTHING * total * laplacian).tocsc())
    log_density = smoother.solve(mass * log_density)
    log_density -= mass @ log_density / total
    if hold is not None:
        log_density *= np.clip(1 - smoother.solve(mass * hold), 0, 1) * (1 - hold)
    return log_density
