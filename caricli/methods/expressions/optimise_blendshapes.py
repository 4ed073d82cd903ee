"""Caricature blendshapes that keep who it is (expressions paper, section 3.2.3)."""

from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from caricli.errors import NumericsError
from caricli.geometry.cholesky import Cholesky
from caricli.geometry.vertex_neighbours import vertex_neighbours

UNMOVED, WHOLE = 0.05, 0.25
"""Shares of an expression's largest displacement: below the first a vertex counts as unmoved, above the second its
displacement is taken as it is."""

_RATIO, _TOLERANCE, _ITERATIONS = 4.0, 1e-11, 200
_THIN = 1e-3


@dataclass(frozen=True)
class BlendshapeWeights:
    """Weights of equation 11: the masked deformation, the structure of the set, smoothness."""

    deformation: float = 1.0
    structure: float = 0.1
    smoothness: float = 0.05


def optimise_blendshapes(initial, normal, vertices, faces, weights=BlendshapeWeights(), least=0.0):  # noqa: B008 (frozen)
    """Displacements D* of a caricature that exaggerate no more than a normal face's and relate as they do.

    Minimises ``sum_i d |B (D*_i - m_i D_i)|^2 + s sum_ij |c_ij| |D*_i - sign(c_ij) D*_j|^2 + o sum_i |B D*_i|^2``
    (equation 11), squares integrated over the surface, with the Laplace-Beltrami operator B of cotangents in units of
    the head's height, so that the weights mean the same on any mesh; the masks m (``masks``) and the cosines c
    (equation 8). For negative cosines equation 9 falls without bound as two shapes part; what bounds it is that
    opposite expressions be each other's reverse, which is the same up to the squares of the two. Vertices that no
    normal expression moves by more than ``UNMOVED`` stay, so constants, which B does not see, have nowhere to go.

    The cosines alone couple the expressions: in the eigenvectors of their matrix one sparse system remains for each,
    solved by conjugate gradients that a few factorisations precondition.

    initial, normal: (K, V, 3) displacements D of the caricature and of the normal face, metres. vertices: (V, 3) of the
    caricature. faces: (F, 3). weights: not negative, that of the deformation above 0. least: as of ``masks``.
    Returns (K, V, 3). Raises NumericsError for degenerate triangles, where nothing moves, and for a part of the mesh
    that moves as a whole.
    """
    if weights.deformation <= 0:
        raise NumericsError("expected a weight of the deformation above 0: without it nothing moves")
    count, moved = len(vertices), displacement_masks(normal, least).max(0)
    free = np.flatnonzero(moved >= UNMOVED)
    if not len(free):
        raise NumericsError("expected expressions that move something, found none")
    _, parts = connected_components(vertex_neighbours(faces, count)[0], directed=False)
    loose = np.setdiff1d(parts, parts[moved < UNMOVED])
    if len(loose):
        found = f"{len(loose)} without, such as that of vertex {np.flatnonzero(parts == loose[0])[0]}"
        raise NumericsError(f"expected in every part of the mesh a vertex that no expression moves, found {found}")
    operator, area = laplace_beltrami(vertices, faces)
    square = (operator.T @ sp.diags(area) @ operator).tocsr()
    wanted = weights.deformation * (masks(normal, least)[..., None] * initial)
    # In displacements times the root of the area the structure term is a multiple of the identity.
    root = np.sqrt(area[free])
    right = square @ wanted.transpose(1, 0, 2).reshape(count, -1)
    right = (right[free] / root[:, None]).reshape(len(free), len(initial), 3)
    scale = sp.diags(1 / root)
    system = (weights.deformation + weights.smoothness) * (scale @ square[free][:, free] @ scale)
    levels, modes = np.linalg.eigh(structure(normal))
    shifts = 2 * weights.structure * np.maximum(levels, 0)
    solved = _solve(system.tocsr(), shifts, np.einsum("vic,ik->vkc", right, modes))
    result = np.zeros((len(initial), count, 3))
    result[:, free] = np.einsum("vkc,ik->ivc", solved, modes) / root[:, None]
    return result


def laplace_beltrami(vertices, faces):
    """The sparse operator (V, V) in units of the height of the vertices, and the area (V,) of each vertex in the same.

    vertices: (V, 3). faces: (F, 3). Raises NumericsError for triangles without an area.
    """
    vertices = np.asarray(vertices, dtype=np.float64) / np.ptp(vertices[:, 1])
    cotangents, area = igl.cotmatrix(vertices, faces), igl.massmatrix(vertices, faces).diagonal()
    if not (np.isfinite(cotangents.data).all() and np.isfinite(area).all() and area.max() > 0):
        raise NumericsError("expected triangles with an area, found some without")
    # Slivers would drown everything else.
    area = np.maximum(area, _THIN * area.mean())
    return sp.diags(-1 / area) @ cotangents, area


def masks(normal, least=0.0):
    """(K, V) how much of a displacement is kept, from 0 to 1: that of equation 6 where the normal face hardly moves.

    Equation 6 as it stands would halve what moves half as far as the farthest vertex.
    normal, least: as of ``displacement_masks``.
    """
    return np.minimum(1, displacement_masks(normal, least) / WHOLE)


def displacement_masks(normal, least=0.0):
    """(K, V) how far every vertex of a normal face moves, of the farthest (equation 6); 0 where nothing moves.

    normal: (K, V, 3) displacements, metres. least: (K,) or a number, metres; an expression that moves nothing so far is
    taken for noise: its displacements count as shares of this.
    """
    lengths = np.linalg.norm(normal, axis=-1)
    farthest = np.maximum(lengths.max(1), least)
    return lengths / np.maximum(farthest, np.finfo(float).tiny)[:, None]


def cosines(normal):
    """(K, K) of the angles between whole displacements (equation 8); 0 for one that moves nothing, but 1 to itself."""
    rows = normal.reshape(len(normal), -1)
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = rows / np.where(lengths > 0, lengths, 1)
    found = rows @ rows.T
    np.fill_diagonal(found, 1.0)
    return found


def structure(normal):
    """(K, K) positive semidefinite S with ``sum_ij |c_ij| |x_i - sign(c_ij) x_j|^2 = 2 x^T S x``."""
    found = cosines(normal)
    return np.diag(np.abs(found).sum(1)) - found


def _solve(system, shifts, right):
    """Solve ``(system + shift_k) x_k = right_k``. right: (n, K, 3). Returns the same shape."""
    solution = np.empty_like(right)
    # Shifts within a factor of each other share a factorisation; the eigenvalues of what it leaves lie within it too.
    floor = 1e-12 * system.diagonal().mean()
    groups = np.floor(np.log(np.maximum(shifts, floor)) / np.log(_RATIO)).astype(int)
    for group in np.unique(groups):
        members = np.flatnonzero(groups == group)
        usual = float(np.sqrt(np.maximum(shifts[members].min(), floor) * np.maximum(shifts[members].max(), floor)))
        factor = Cholesky(system + usual * sp.identity(system.shape[0]))
        for k in members:
            solution[:, k] = _conjugate_gradients(system, shifts[k], right[:, k], factor.solve)
    return solution


def _conjugate_gradients(system, shift, right, precondition):
    """Columns of (n, 3) side by side."""
    found = precondition(right)
    residual = right - system @ found - shift * found
    goal = _TOLERANCE * np.maximum(np.linalg.norm(right, axis=0), np.finfo(float).tiny)
    way, last = np.zeros_like(right), np.ones(right.shape[1])
    for step in range(_ITERATIONS):
        if (np.linalg.norm(residual, axis=0) <= goal).all():
            break
        preconditioned = precondition(residual)
        product = (residual * preconditioned).sum(0)
        way = preconditioned + (product / last if step else 0.0) * way
        image = system @ way + shift * way
        length = product / np.maximum((way * image).sum(0), np.finfo(float).tiny)
        found, residual, last = found + length * way, residual - length * image, np.where(product > 0, product, 1.0)
    return found
