"""How likely a latent is."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.linalg import solve_triangular


@dataclass(frozen=True, eq=False)
class Prior:
    """A normal distribution of latents.

    mean: (D,). factor: (D, D), lower Cholesky factor of the covariance.
    """

    mean: np.ndarray
    factor: np.ndarray

    @classmethod
    def of(cls, latents: np.ndarray, ridge: float = 1e-6) -> Self:
        """The prior of training latents (N, D); ridge: added to the covariance, relative to its mean variance."""
        centred = latents - latents.mean(0)
        covariance = centred.T @ centred / max(len(latents) - 1, 1)
        covariance += ridge * np.trace(covariance) / len(covariance) * np.eye(len(covariance))
        return cls(latents.mean(0), np.linalg.cholesky(covariance))

    @classmethod
    def standard(cls, dimension: int) -> Self:
        """The prior of latents that are white already."""
        return cls(np.zeros(dimension), np.eye(dimension))

    def whiten(self, latents: np.ndarray) -> np.ndarray:
        """Latents (..., D) in standard deviations: zero mean, unit covariance."""
        rows = (latents - self.mean).reshape(-1, len(self.mean))
        return solve_triangular(self.factor, rows.T, lower=True, check_finite=False).T.reshape(np.shape(latents))

    def colour(self, whitened: np.ndarray) -> np.ndarray:
        """The inverse of ``whiten``."""
        return self.mean + whitened @ self.factor.T

    def rms(self, latents: np.ndarray) -> np.ndarray:
        """Root mean square of the whitened latents over their dimensions: about 1 for a typical face. (...,)."""
        return np.sqrt((self.whiten(latents) ** 2).mean(-1))

    def sample(self, generator: np.random.Generator, count: int) -> np.ndarray:
        """Draw latents (count, D)."""
        return self.colour(generator.normal(size=(count, len(self.mean))))
