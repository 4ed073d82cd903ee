"""Deformation of a region whose surroundings stay exactly as they are."""

import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import untangle
from caricli.methods.gesture.settings import GestureSettings
from caricli.template.template import Template

_UNTANGLING = 8
"""Rounds of turning triangles back."""

_LOOSE = 1e-9
"""Of the usual stiffness, what holds a part that hangs on nothing where it is."""


def held_deformation(
    vertices: np.ndarray, faces: np.ndarray, region: np.ndarray, moves: np.ndarray, length: float
) -> np.ndarray:
    """Vertices of a region that follow some of them, as a plate under tension.

    The displacement d minimises ``integral length^2 |L d|^2 + |grad d|^2`` (Sorkine et al. 2004 without their detail,
    which displacements keep; the second term is ours), with the given moves and 0 outside the region. Without tension
    slopes at handles go on beyond them, and lids and lips, which are free on one side, are torn open.

    vertices: (V, 3). faces: (F, 3). region: (V,) bool. moves: (V, 3) metres, NaN where it is not given. length: metres,
    over which a slope fades.
    Returns (V, 3); outside the region nothing has changed.
    """
    start = np.asarray(vertices, np.float64)
    given = np.isfinite(moves).all(1) & region
    free = np.flatnonzero(region & ~given)
    moved = np.where(given[:, None], moves, 0.0)
    if len(free):
        slope = -igl.cotmatrix(start, faces)
        area = igl.massmatrix(start, faces, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
        bend = slope @ sp.diags(1 / np.maximum(area, 1e-6 * area.mean())) @ slope
        energy = (length**2 * bend + slope).tocsr()[free]
        moved[free] = solved(energy[:, free], -(energy @ moved))
    return np.where(region[:, None], start + moved, vertices)


def solved(system: sp.spmatrix, right: np.ndarray) -> np.ndarray:
    """The solution (N, M) of a symmetric system (N, N) that may be loose in places. right: (N, M)."""
    least = _LOOSE * float(system.diagonal().mean())
    return Cholesky((system + least * sp.identity(len(right))).tocsc()).solve(right)


def sound_move(
    vertices: np.ndarray, moved: np.ndarray, region: np.ndarray, template: Template, settings: GestureSettings
) -> tuple[np.ndarray, float]:
    """As much of a move as turns no triangle over that was not.

    Mouth cavity and eye sockets give way to a skin that comes down on them, inside the region or not.
    vertices, moved: (V, 3), before and after. region: (V,) bool, outside of which nothing has moved.
    Returns (V, 3), and the share of the way that was gone.
    """
    gradients = template.gradients
    some = np.flatnonzero(region[template.faces].any(1))
    before = flipped_triangles(vertices, gradients, some)

    def turned(shape: np.ndarray) -> bool:
        return bool((flipped_triangles(shape, gradients, some) & ~before).any())

    if not turned(moved):
        return _tucked(vertices, moved, region, template), 1.0
    smoothed = np.where(region[:, None], untangle(moved, gradients, _UNTANGLING, vertices), vertices)
    low = 0.0
    high = 1.0
    for trial in range(1 + settings.bisections):
        share = (low + high) / 2 if trial else high
        if turned(vertices + share * (smoothed - vertices)):
            high = share
        else:
            low = share
        if low == high:
            break
    return _tucked(vertices, vertices + low * (smoothed - vertices), region, template), low


def _tucked(vertices: np.ndarray, moved: np.ndarray, region: np.ndarray, template: Template) -> np.ndarray:
    """Moved vertices (V, 3) with the pockets behind the skin, as far as they did not come through it before."""
    tuck = template.cavities.tuck
    free = region | (tuck(vertices) == vertices).all(1)
    return np.where(free[:, None], tuck(moved), moved)
