"""A displacement that follows what is known of it in places, is smooth everywhere, and folds nowhere."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky

_HELD = 1e6
"""Weight of a node that stays; a sample has one at most."""

_LOOSER = 0.25
"""What is left, at each round, of the samples' weight where the displacement nearly folds."""

_AROUND = 2
"""Cells around those that nearly fold where the samples lose weight."""

_ROUNDS = 8
"""Solves at most; what nearly folds then is made weaker as a whole."""

_HALVINGS = 12
"""Of the search for the strength that does not fold."""


@dataclass(frozen=True)
class Smoothness:
    """What a displacement may be.

    length: cells; what is smaller is smoothed away. least: area that a small square keeps at least, as a share of its
    own; above zero nothing folds.
    """

    length: float = 1.5
    least: float = 0.2


@dataclass(frozen=True, eq=False)
class Samples:
    """Where a displacement is known, in cells of the grid that it is wanted on.

    places: (N, 2) x, y. moves: (N, 2). weights: (N,) cells that each speaks for.
    """

    places: np.ndarray
    moves: np.ndarray
    weights: np.ndarray


@dataclass(frozen=True)
class Borders:
    """Where a grid ends within a picture that goes on unmoved; elsewhere the picture ends with the grid."""

    left: bool
    top: bool
    right: bool
    bottom: bool


def smooth_displacement(
    samples: Samples, shape: tuple[int, int], borders: Borders, smoothness: Smoothness
) -> np.ndarray:
    """The least ``sum w |u(x) - m|^2 + l^4 integral |D^2 u|^2`` on a grid: a thin plate that samples pull at.

    Where squares would fold, or be pressed below ``smoothness.least`` of their area, the samples around lose weight and
    the plate becomes as much stiffer, again and again; what then still folds is made weaker as a whole.
    samples: Samples. shape: (R, C) nodes, at least 4 each. borders: value and slope are zero where the picture goes on;
    where it ends nodes stay on its border, but may slide along it.
    Returns (R, C, 2) cells, what is to be added to a node's x, y. Raises NumericsError.
    """
    plate = _Plate(samples, shape, borders, smoothness.length)
    loose = np.ones(shape)
    moves = plate.solve(loose)
    for _ in range(_ROUNDS - 1):
        bad = least_areas(moves) < smoothness.least
        if not bad.any():
            return moves
        loose = np.where(_nodes_around(bad), _LOOSER * loose, loose)
        moves = plate.solve(loose)
    return _unfolded(moves, smoothness.least)


def least_areas(moves: np.ndarray) -> np.ndarray:
    """What becomes of the area of cells, at the corner where it is least: above zero nothing folds.

    moves: (R, C, 2) in cells. Returns (R - 1, C - 1).
    """
    right = np.diff(moves, axis=1) + [1, 0]
    down = np.diff(moves, axis=0) + [0, 1]
    sides = [(a, b) for a in (right[:-1], right[1:]) for b in (down[:, :-1], down[:, 1:])]
    return np.min([a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0] for a, b in sides], axis=0)


class _Plate:
    """The system of a thin plate and of the samples that pull at it."""

    def __init__(self, samples: Samples, shape: tuple[int, int], borders: Borders, length: float) -> None:
        """length: cells."""
        self.samples = samples
        self.shape = shape
        self.pick = _bilinear(samples.places, shape)
        self.bends = length**2 * _bends(shape)
        self.means = sp.diags(1 / abs(self.bends).sum(axis=1)) @ abs(self.bends)
        self.held = _held(shape, borders)

    def solve(self, loose: np.ndarray) -> np.ndarray:
        """Displacement (R, C, 2). loose: (R, C) above 0, what is left of the samples' weight."""
        pull = self.pick.T @ sp.diags(self.samples.weights * (self.pick @ loose.ravel()))
        stiff = sp.diags(1 / (self.means @ loose.ravel()))
        plate = pull @ self.pick + self.bends.T @ stiff @ self.bends
        right = pull @ self.samples.moves
        axes = [Cholesky(plate + sp.diags(_HELD * held)).solve(right[:, [k]]) for k, held in enumerate(self.held)]
        moves = np.concatenate(axes, axis=1)
        moves[self.held.T] = 0  # not only nearly
        return moves.reshape(*self.shape, 2)


def _bilinear(places: np.ndarray, shape: tuple[int, int]) -> sp.csr_array:
    """(N, R C) shares of the four nodes around each place (N, 2)."""
    first = np.clip(np.floor(places), 0, [shape[1] - 2, shape[0] - 2]).astype(int)
    share = places - first
    corner = first[:, 1] * shape[1] + first[:, 0]
    ids = corner[:, None] + [0, 1, shape[1], shape[1] + 1]
    across = np.stack([1 - share[:, 0], share[:, 0]], 1)
    down = np.stack([1 - share[:, 1], share[:, 1]], 1)
    weights = (down[:, :, None] * across[:, None]).reshape(-1, 4)
    starts = np.arange(0, ids.size + 1, 4)
    return sp.csr_array((weights.ravel(), ids.ravel(), starts), (len(places), shape[0] * shape[1]))


def _bends(shape: tuple[int, int]) -> sp.csr_array:
    """(B, R C) second differences, squares of which add up to those of the second derivatives."""
    rows, columns = (sp.eye_array(count, format="csr") for count in shape)
    slopes = [eye[1:] - eye[:-1] for eye in (rows, columns)]
    second = [slope[1:] - slope[:-1] for slope in slopes]
    kinds = [sp.kron(rows, second[1]), sp.kron(second[0], columns), np.sqrt(2) * sp.kron(*slopes)]
    return sp.vstack(kinds, format="csr")


def _held(shape: tuple[int, int], borders: Borders) -> np.ndarray:
    """(2, R C) bool: of x and of y, the nodes that stay."""
    still = np.zeros(shape, bool)
    still[:, : 2 * borders.left] = True
    still[: 2 * borders.top] = True
    still[:, shape[1] - 2 * borders.right :] = True
    still[shape[0] - 2 * borders.bottom :] = True
    held = np.stack([still, still])
    held[0, :, [0, -1]] = True
    held[1, [0, -1]] = True
    return held.reshape(2, -1)


def _nodes_around(bad: np.ndarray) -> np.ndarray:
    """(R, C) bool: nodes within a few cells of bad ones (R - 1, C - 1)."""
    nodes = np.zeros(np.add(bad.shape, 1), bool)
    for row, column in np.argwhere(bad):
        nodes[max(row - _AROUND, 0) : row + _AROUND + 2, max(column - _AROUND, 0) : column + _AROUND + 2] = True
    return nodes


def _unfolded(moves: np.ndarray, least: float) -> np.ndarray:
    """As much of a displacement as leaves squares their area."""
    if least_areas(moves).min() >= least:
        return moves
    low = 0.0
    high = 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if least_areas(middle * moves).min() >= least:
            low = middle
        else:
            high = middle
    return low * moves
