"""The mean of a Gaussian process, a function of latents."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class GaussianProcess:
    """``g(z) = exp(-|z * scale - centres|^2 / 2) @ weights``.

    scale: (D,) of the latents. centres: (M, D) scaled latents. weights: (M, E).
    """

    scale: np.ndarray
    centres: np.ndarray
    weights: np.ndarray

    def predict(self, latents: np.ndarray) -> np.ndarray:
        """Latents (..., D) to values (..., E)."""
        return gaussian_kernel(latents * self.scale, self.centres) @ self.weights

    def jacobian(self, latent: np.ndarray) -> np.ndarray:
        """Derivatives (E, D) of the values by the latent (D,)."""
        scaled = latent * self.scale
        kernel = gaussian_kernel(scaled, self.centres)
        slopes = kernel[:, None] * (self.centres - scaled) * self.scale
        return self.weights.T @ slopes


def gaussian_kernel(points: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """``exp(-|p - c|^2 / 2)`` of points (..., D) and centres (M, D): (..., M)."""
    squares = (points**2).sum(-1, keepdims=True) + (centres**2).sum(-1)
    # Far from the origin rounding leaves squares of distances a little below zero.
    return np.exp(np.minimum(points @ centres.T - squares / 2, 0))
