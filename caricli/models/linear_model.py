"""What models share whose vertices are linear in the latent."""

import numpy as np
from scipy.sparse import csr_matrix

from caricli.geometry.per_column import per_column
from caricli.models.linear_basis import LinearBasis, direction_products
from caricli.models.model_id import NamedByWeights
from caricli.models.prior import Prior
from caricli.structures import SeenPeople
from caricli.template.template import Template


class LinearModel(NamedByWeights):
    """vertices = mean + latent @ basis; a latent is in standard deviations of the training shapes."""

    seen: SeenPeople | None = None

    def __init__(self, template: Template, basis: LinearBasis, noise: float = 0.0) -> None:
        """basis: metres, independent.

        noise: metres, how far a coordinate is expected from what the basis makes of it: encoding then prefers short
        latents; without noise it is the orthogonal projection.
        """
        self.template = template
        self.mean = basis.mean
        self.basis = basis.basis
        self.prior = Prior.standard(len(self.basis))
        flat = self.basis.reshape(len(self.basis), -1)
        self._encoder = np.linalg.solve(direction_products(flat, ridge=noise**2), flat)

    def prepare(self) -> None:
        """See ShapeModel: the fits need nothing beyond what is here."""

    def decode(self, latents: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        return self.mean + np.tensordot(latents, self.basis, 1)

    def decode_on(self, latents: np.ndarray, matrix: csr_matrix) -> np.ndarray:
        """See ShapeModel."""
        return per_column(matrix, self.decode(latents))

    def decode_points(self, latent: np.ndarray, points: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        return self.mean[points] + np.tensordot(latent, self.basis[:, points], 1)

    def points_jacobian(self, latent: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ShapeModel."""
        return self.decode_points(latent, points), np.moveaxis(self.basis[:, points], 0, -1)

    def encode(self, vertices: np.ndarray) -> np.ndarray:
        """See ShapeModel: ``|vertices - decode(z)|^2 + noise^2 |z|^2`` at its smallest."""
        return (vertices - self.mean).reshape(*vertices.shape[:-2], self.mean.size) @ self._encoder.T
