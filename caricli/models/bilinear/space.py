"""Rows of numbers that are bilinear in who somebody is and what the face does."""

from typing import Self

import numpy as np

from caricli.models.bilinear.n_mode_svd import n_mode_svd
from caricli.models.prior import Prior

_ROUNDS = 60
"""Steps of an encoding at most; typically eight are taken."""

_BATCH = 256
"""Rows that are encoded at once."""

_SETTLED = 1e-9
"""Of the cost: steps that lower it by less end an encoding."""

_DAMPING = (1e-4, 10.0)
"""Of the first step, and the factor by which a step makes it smaller or larger."""


class BilinearSpace:
    """row = core x_2 u x_3 (1, w) (sketch paper, equation 1); a code is u, then w.

    u and v of the paper can share a factor in any way. Here the first number of v is 1, in a basis whose first
    direction is the mean of the training expressions; w are the others.
    """

    def __init__(self, core: np.ndarray, prior: Prior, noise: float) -> None:
        """core: (M, I, E). prior: of codes (I + E - 1,). noise: how far a number is expected from what the core makes.

        Raises ValueError where the prior is not of such codes.
        """
        self.core = core
        self.prior = prior
        self.noise = noise
        self.identity = core.shape[1]
        if prior.mean.shape != (self.identity + core.shape[2] - 1,) or prior.factor.shape != 2 * prior.mean.shape:
            raise ValueError(f"a prior of {prior.mean.shape} for a core of {core.shape}")
        inverse = np.linalg.inv(prior.factor)
        self._precision = inverse.T @ inverse * noise**2

    @classmethod
    def train(cls, table: np.ndarray, identity: int, expression: int) -> Self:
        """Decompose a table (P, E, M) of people with every expression; see ``n_mode_svd``."""
        modes = n_mode_svd(table, identity, expression)
        turn = _turn_to(modes.expressions.mean(0))
        core = modes.core @ turn.T
        expressions = modes.expressions @ turn.T
        scale = expressions[:, :1]
        codes = np.concatenate(
            [
                (modes.people[:, None] * scale).reshape(-1, core.shape[1]),
                np.tile(expressions[:, 1:] / scale, (len(table), 1)),
            ],
            1,
        )
        squares = 0.0
        for k, v in enumerate(expressions):
            squares += ((modes.people @ (core @ v).T - table[:, k]) ** 2).sum()
        return cls(core, Prior.of(codes), float(np.sqrt(squares / table.size)))

    def fitted_to(self, rows: np.ndarray) -> Self:
        """The same with the prior of rows (N, M), which each have a u and a v of their own."""
        codes = np.concatenate([self.encode(rows[k : k + _BATCH]) for k in range(0, len(rows), _BATCH)])
        return type(self)(self.core, Prior.of(codes), self.noise)

    def decode(self, codes: np.ndarray) -> np.ndarray:
        """Codes (..., D) to rows (..., M)."""
        u, v = self.parts(np.asarray(codes))
        both = u[..., :, None] * v[..., None, :]
        return both.reshape(*both.shape[:-2], -1) @ self.core.reshape(len(self.core), -1).T

    def parts(self, codes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The paper's u (..., I) and v (..., E) of codes (..., D)."""
        u, w = codes[..., : self.identity], codes[..., self.identity :]
        return u, np.concatenate([np.ones_like(u[..., :1]), w], -1)

    def jacobian(self, codes: np.ndarray) -> np.ndarray:
        """Derivatives (N, M, D) of the rows by codes (N, D)."""
        u, v = self.parts(codes)
        by_u = np.einsum("mie,ne->nmi", self.core, v, optimize=True)
        by_w = np.einsum("mie,ni->nme", self.core[:, :, 1:], u, optimize=True)
        return np.concatenate([by_u, by_w], -1)

    def encode(self, rows: np.ndarray, weights: np.ndarray | None = None, rounds: int = _ROUNDS) -> np.ndarray:
        """The likeliest codes of rows: ``|weights (row - decode(z))|^2 + noise^2 |whitened z|^2`` at its smallest.

        Levenberg-Marquardt steps from the mean code, for all rows at once.

        rows: (N, M). weights: (N, M) from 0, which is not known, to 1; all 1 by default. rounds: steps at most; after
        few, codes are on their way.
        Returns (N, D).
        """
        codes = np.tile(self.prior.mean, (len(rows), 1))
        damping = np.full(len(rows), _DAMPING[0])
        weights = np.ones((1, 1)) if weights is None else weights
        gaps, costs = self._costs(codes, rows, weights)
        active = np.arange(len(rows))
        for _ in range(rounds):
            if not len(active):
                break
            own = weights if len(weights) == 1 else weights[active]
            steps = self._steps(codes[active], gaps[active], own, damping[active])
            trial = codes[active] + steps
            trial_gaps, trial_costs = self._costs(trial, rows[active], own)
            gained = costs[active] - trial_costs
            better = gained > 0
            still = np.abs(gained) < _SETTLED * costs[active] + 1e-300
            moved = active[better]
            codes[moved], gaps[moved], costs[moved] = trial[better], trial_gaps[better], trial_costs[better]
            damping[active] *= np.where(better, 1 / _DAMPING[1], _DAMPING[1])
            active = active[~still]
        return codes

    def _costs(self, codes: np.ndarray, rows: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Weighted gaps (N, M) and what is minimised (N,)."""
        gaps = weights * (rows - self.decode(codes))
        away = codes - self.prior.mean
        return gaps, (gaps**2).sum(1) + np.einsum("nd,dk,nk->n", away, self._precision, away)

    def _steps(self, codes: np.ndarray, gaps: np.ndarray, weights: np.ndarray, damping: np.ndarray) -> np.ndarray:
        jacobian = weights[..., None] * self.jacobian(codes)
        system = jacobian.swapaxes(1, 2) @ jacobian + self._precision
        right = (gaps[:, None] @ jacobian)[:, 0] - (codes - self.prior.mean) @ self._precision
        diagonal = np.einsum("ndd->nd", system) * damping[:, None]
        system += diagonal[..., None] * np.eye(system.shape[1])
        return np.linalg.solve(system, right[..., None])[..., 0]


def _turn_to(direction: np.ndarray) -> np.ndarray:
    """A rotation or reflection (D, D) after which a direction (D,) is along the first axis."""
    columns = np.concatenate([direction[:, None] / np.linalg.norm(direction), np.eye(len(direction))], 1)
    turn = np.linalg.qr(columns)[0].T
    return turn * np.sign(turn[0] @ direction)
