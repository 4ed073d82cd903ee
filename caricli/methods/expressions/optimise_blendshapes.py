"""Caricature blendshapes that keep who it is (expressions paper, section 3.2.3)."""

from collections.abc import Callable

import igl
import numpy as np
import scipy.sparse as sp

from caricli.errors import NumericsError
from caricli.geometry.cholesky import Cholesky
from caricli.geometry.repair.components import BOND, mesh_components
from caricli.methods.expressions.settings import BlendshapeWeights
from caricli.structures import Mesh

UNMOVED = 0.05
"""Share of an expression's largest displacement below which a vertex counts as unmoved."""

WHOLE = 0.25
"""Share of an expression's largest displacement above which a displacement is taken as it is."""

_RATIO = 4.0
"""Shifts within this factor of each other share a factorisation; smaller means more of them and fewer iterations."""

_TOLERANCE = 1e-11
"""Of a right side: residual that ends conjugate gradients."""

_ITERATIONS = 200
"""Steps of conjugate gradients at most; a few do, because the factorisation is near."""

_THIN = 1e-3
"""Of the mean area: least area of a vertex, because slivers would drown everything else."""

_UNSHIFTED = 1e-12
"""Of the mean diagonal: shifts below it are taken for none."""


def optimise_blendshapes(
    initial: np.ndarray,
    normal: np.ndarray,
    mesh: Mesh,
    weights: BlendshapeWeights = BlendshapeWeights(),  # noqa: B008 (frozen)
    least: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Displacements D* of a caricature that exaggerate no more than a normal face's and relate as they do.

    Minimises ``sum_i d |B (D*_i - m_i D_i)|^2 + s sum_ij |c_ij| |D*_i - sign(c_ij) D*_j|^2 + o sum_i |B D*_i|^2``
    (equation 11), squares integrated over the surface, with the Laplace-Beltrami operator B of cotangents in units of
    the head's height, so that the weights mean the same on any mesh; the masks m (``masks``) and the cosines c
    (equation 8). For negative cosines equation 9 falls without bound as two shapes part; what bounds it is that
    opposite expressions be each other's reverse, which is the same up to the squares of the two. Vertices that no
    normal expression moves by more than ``UNMOVED`` stay, so constants, which B does not see, have nowhere to go.

    The cosines alone couple the expressions: in the eigenvectors of their matrix one sparse system remains for each,
    solved by conjugate gradients that a few factorisations precondition.

    initial, normal: (K, V, 3) displacements D of the caricature and of the normal face, metres. mesh: Mesh of the
    caricature. weights: not negative, that of the deformation above 0. least: as of ``masks``.
    Returns (K, V, 3). Raises NumericsError for degenerate triangles, where nothing moves, and where everything does.
    """
    if weights.deformation <= 0:
        raise NumericsError("expected a weight of the deformation above 0: without it nothing moves")
    count = len(mesh.vertices)
    free = _free_vertices(displacement_masks(normal, least).max(0))
    operator, area = laplace_beltrami(mesh)
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


def _free_vertices(moved: np.ndarray) -> np.ndarray:
    """Ids of the vertices that move, by how far they do (V,); NumericsError where none is, or all are."""
    free = np.flatnonzero(moved >= UNMOVED)
    if not len(free):
        raise NumericsError("expected expressions that move something, found none")
    if len(free) == len(moved):
        raise NumericsError("expected vertices that no expression moves, found none")
    return free


def laplace_beltrami(mesh: Mesh) -> tuple[sp.spmatrix, np.ndarray]:
    """The sparse operator (V, V) in units of the height of a mesh, and the area (V,) of each vertex in the same.

    Its components hang on the largest one by their bonds (``mesh_components``).

    Raises NumericsError for triangles without an area.
    """
    vertices = np.asarray(mesh.vertices, dtype=np.float64) / np.ptp(mesh.vertices[:, 1])
    cotangents = igl.cotmatrix(vertices, mesh.faces)
    area = igl.massmatrix(vertices, mesh.faces).diagonal()
    if not (np.isfinite(cotangents.data).all() and np.isfinite(area).all() and area.max() > 0):
        raise NumericsError("expected triangles with an area, found some without")
    area = np.maximum(area, _THIN * area.mean())
    own, hold = mesh_components(vertices, mesh.faces).pull(np.zeros(0, int))
    return sp.diags(1 / area) @ (BOND * -cotangents.diagonal().mean() * (own + hold) - cotangents), area


def masks(normal: np.ndarray, least: np.ndarray | float = 0.0) -> np.ndarray:
    """(K, V) how much of a displacement is kept, from 0 to 1: that of equation 6 where the normal face hardly moves.

    Equation 6 as it stands would halve what moves half as far as the farthest vertex.
    normal, least: as of ``displacement_masks``.
    """
    return np.minimum(1, displacement_masks(normal, least) / WHOLE)


def displacement_masks(normal: np.ndarray, least: np.ndarray | float = 0.0) -> np.ndarray:
    """(K, V) how far every vertex of a normal face moves, of the farthest (equation 6); 0 where nothing moves.

    normal: (K, V, 3) displacements, metres. least: (K,) or a number, metres; an expression that moves nothing so far is
    taken for noise: its displacements count as shares of this.
    """
    lengths = np.linalg.norm(normal, axis=-1)
    farthest = np.maximum(lengths.max(1), least)
    return lengths / np.maximum(farthest, np.finfo(float).tiny)[:, None]


def cosines(normal: np.ndarray) -> np.ndarray:
    """(K, K) of the angles between whole displacements (equation 8); 0 for one that moves nothing, but 1 to itself."""
    rows = normal.reshape(len(normal), -1)
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = rows / np.where(lengths > 0, lengths, 1)
    products = rows @ rows.T
    np.fill_diagonal(products, 1.0)
    return products


def structure(normal: np.ndarray) -> np.ndarray:
    """(K, K) positive semidefinite S with ``sum_ij |c_ij| |x_i - sign(c_ij) x_j|^2 = 2 x^T S x``."""
    cosine = cosines(normal)
    return np.diag(np.abs(cosine).sum(1)) - cosine


def _solve(system: sp.csr_matrix, shifts: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve ``(system + shift_k) x_k = right_k``. right: (n, K, 3). Returns the same shape."""
    solution = np.empty_like(right)
    # Shifts within a factor of each other share a factorisation; the eigenvalues of what it leaves lie within it too.
    floor = _UNSHIFTED * system.diagonal().mean()
    groups = np.floor(np.log(np.maximum(shifts, floor)) / np.log(_RATIO)).astype(int)
    for group in np.unique(groups):
        members = np.flatnonzero(groups == group)
        usual = float(np.sqrt(np.maximum(shifts[members].min(), floor) * np.maximum(shifts[members].max(), floor)))
        factor = Cholesky(system + usual * sp.identity(system.shape[0]))
        for k in members:
            solution[:, k] = _conjugate_gradients(system, shifts[k], right[:, k], factor.solve)
    return solution


def _conjugate_gradients(
    system: sp.csr_matrix, shift: float, right: np.ndarray, precondition: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """The solution (n, 3) of ``(system + shift) x = right``, its columns side by side."""
    tiny = np.finfo(float).tiny
    solution = precondition(right)
    residual = right - system @ solution - shift * solution
    goal = _TOLERANCE * np.maximum(np.linalg.norm(right, axis=0), tiny)
    way = np.zeros_like(right)
    last = np.ones(right.shape[1])
    for step in range(_ITERATIONS):
        if (np.linalg.norm(residual, axis=0) <= goal).all():
            break
        preconditioned = precondition(residual)
        product = (residual * preconditioned).sum(0)
        way = preconditioned + (product / last if step else 0.0) * way
        image = system @ way + shift * way
        length = product / np.maximum((way * image).sum(0), tiny)
        solution = solution + length * way
        residual = residual - length * image
        last = np.where(product > 0, product, 1.0)
    return solution
