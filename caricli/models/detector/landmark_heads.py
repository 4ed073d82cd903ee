"""Landmarks, and how sure they are, of the features that the detector's network makes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from caricli.models.checks import named_weights

HEADS = ("heat.weight", "heat.bias", "about", "about_bias")
"""Names of what is not in `detector_graph`."""


@dataclass(frozen=True, eq=False)
class LandmarkPlaces:
    """What windows show of landmarks: of ``networks.HeatMaps`` what is used.

    mean: (B, L, 2) cells, x and y, 0 at the centre of the first. covariance: (B, L, 2, 2) square cells, calibrated.
    visible: (B, L) logits.
    """

    mean: np.ndarray
    covariance: np.ndarray
    visible: np.ndarray


@dataclass(frozen=True, eq=False)
class LandmarkHeads:
    """The last step of ``networks.DetectorNetwork.read``.

    heat: (L, C) and heat_bias: (L,), of the heat maps. about: (L, C, 3) and about_bias: (L, 3), of two logarithms of
    doubt and the visibility.
    """

    heat: np.ndarray
    heat_bias: np.ndarray
    about: np.ndarray
    about_bias: np.ndarray

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray], landmarks: int, channels: int) -> "LandmarkHeads":
        """Take them from the arrays of a detector's weights. Raises InputError when they are those of another one."""
        shapes = ((landmarks, channels, 1, 1), (landmarks,), (landmarks, channels, 3), (landmarks, 3))
        heat, *others = (named_weights(arrays, name, shape) for name, shape in zip(HEADS, shapes, strict=True))
        return cls(heat[:, :, 0, 0], *others)

    def read(self, features: np.ndarray) -> LandmarkPlaces:
        """Landmarks of features (B, C, h, w), float32."""
        count, channels, height, width = features.shape
        flat = features.reshape(count, channels, height * width)
        logits = self.heat @ flat + self.heat_bias[:, None]
        masses = np.exp(logits - logits.max(-1, keepdims=True))
        masses /= masses.sum(-1, keepdims=True)
        mean, spread = _moments(masses.reshape(*masses.shape[:2], height, width).astype(np.float64))
        seen = masses @ flat.swapaxes(1, 2)
        about = np.einsum("blc,lck->blk", seen, self.about) + self.about_bias
        # As in the training: a heat map that learnt blurred places is wider than the doubt, and one that is never
        # wrong by more than a cell says nothing of what is below one.
        factor = np.exp(np.clip(about[..., 0], -6, 3).astype(np.float64))[..., None, None]
        floor = np.exp(np.clip(about[..., 1], -6, 6).astype(np.float64))[..., None, None]
        return LandmarkPlaces(mean, factor * spread + floor * np.eye(2), about[..., 2].astype(np.float64))


def _moments(masses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean (B, L, 2), x and y, and covariance (B, L, 2, 2) of masses (B, L, h, w) whose sums are one, in cells."""
    height, width = masses.shape[2:]
    x = np.arange(width) - (width - 1) / 2
    y = np.arange(height) - (height - 1) / 2
    sums = np.vander(y, 3, increasing=True).T @ masses @ np.vander(x, 3, increasing=True)
    mean = np.stack([sums[:, :, 0, 1], sums[:, :, 1, 0]], -1)
    squares = np.stack([sums[:, :, 0, 2], sums[:, :, 1, 1], sums[:, :, 1, 1], sums[:, :, 2, 0]], -1)
    spread = squares.reshape(*mean.shape, 2) - mean[..., :, None] * mean[..., None, :]
    return mean + [(width - 1) / 2, (height - 1) / 2], spread
