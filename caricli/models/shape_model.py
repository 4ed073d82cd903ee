"""What every shape model offers, whatever it is made of."""

from collections.abc import Mapping
from typing import Any, Protocol, Self

import numpy as np
from scipy.sparse import csr_matrix

from caricli.models.prior import Prior
from caricli.structures import SeenPeople
from caricli.template.template import Template


class ShapeModel(Protocol):
    """A space of shapes of one template. Arrays are NumPy; leading dimensions are batches; metres.

    ``kind`` names the class in a checkpoint. ``model_id`` names the weights, see the function of this name.
    ``seen`` says whom it was trained with; None where the checkpoint does not.
    """

    kind: str
    template: Template
    prior: Prior
    seen: SeenPeople | None

    @property
    def model_id(self) -> str:
        """SHA-256 of ``tensors()``: latents of other weights mean other shapes."""

    def prepare(self) -> None:
        """Factor what fits need, so that the first one takes no longer than the others."""

    def decode(self, latents: np.ndarray) -> np.ndarray:
        """Latents (..., D) to vertices (..., V, 3)."""

    def decode_on(self, latents: np.ndarray, matrix: csr_matrix) -> np.ndarray:
        """Latents (..., D) to positions (..., K, 3) at places given as weights (K, V) of the template's vertices."""

    def decode_points(self, latent: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Positions (K, 3) of the vertices ``points`` for one latent (D,)."""

    def points_jacobian(self, latent: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same positions and their derivatives (K, 3, D) by the latent."""

    def encode(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices (..., V, 3) to the latents (..., D) that are nearest by what the model is fitted to."""

    def tensors(self) -> dict[str, np.ndarray]:
        """Everything beyond the template that a checkpoint must hold."""

    @classmethod
    def from_tensors(cls, template: Template, tensors: Mapping[str, np.ndarray]) -> Self:
        """Rebuild from ``tensors()``. Raises KeyError or ValueError for what does not fit the template or itself."""


class ComponentModel(ShapeModel, Protocol):
    """A ShapeModel that one call trains on shapes, as ``train_linear`` does."""

    @classmethod
    def train(cls, template: Template, shapes: np.ndarray, config: Any) -> Self:
        """Fit to shapes (N, V, 3) metres. config: the kind's own, see TrainingConfig.

        Raises NumericsError when all of the shapes are the same.
        """
