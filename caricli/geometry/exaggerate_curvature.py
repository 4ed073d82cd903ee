"""Exaggeration by curvature: steep where the surface bends, calm where it is flat."""

import igl
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from caricli.errors import NumericsError

SMOOTHING = 2e-4
MAX_LOG_WEIGHT = 1.2


def exaggerate_curvature(vertices, faces, exponents, hold=None):
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
    # Rounding gives a triangle of three points in line a little area, and cotangents without meaning.
    if not double_areas.min() > 1e-12 * double_areas.mean() or len(np.unique(faces)) < len(vertices):
        raise NumericsError("curvature exaggeration needs triangles with an area, and every vertex in one")
    laplacian, mass = -igl.cotmatrix(vertices, faces), igl.massmatrix(vertices, faces).diagonal()
    total = mass.sum()
    # The angle defect at the boundary is no curvature; the clip keeps both ends of the logarithm sane.
    density = np.abs(igl.gaussian_curvature(vertices, faces)) / mass * total
    boundary = np.zeros(len(vertices), dtype=bool)
    boundary[igl.boundary_facets(faces)[0].ravel()] = True
    density[boundary] = np.median(density)
    log_density = np.log(np.clip(density, 1e-3, None))
    smoother = splu((sp.diags(mass) + SMOOTHING * total * laplacian).tocsc())
    log_density = smoother.solve(mass * log_density)
    log_density -= mass @ log_density / total
    if hold is not None:
        log_density *= np.clip(1 - smoother.solve(mass * hold), 0, 1) * (1 - hold)
    gradient, areas = igl.grad(vertices, faces), np.tile(double_areas / 2, 3)
    factor = splu((laplacian + 1e-9 * laplacian.diagonal().mean() * sp.identity(len(vertices))).tocsc())
    slopes = gradient @ vertices
    results = []
    for exponent in exponents:
        weights = np.exp(np.clip(exponent * log_density, -MAX_LOG_WEIGHT, MAX_LOG_WEIGHT))
        weights /= weights @ mass / total
        scaled = np.tile(weights[faces].mean(1), 3) * areas
        exaggerated = factor.solve(gradient.T @ (scaled[:, None] * slopes))
        results.append(exaggerated + vertices.mean(0) - exaggerated.mean(0))
    results = np.array(results)
    if not np.isfinite(results).all():
        raise NumericsError("curvature exaggeration did not stay finite")
    return results
