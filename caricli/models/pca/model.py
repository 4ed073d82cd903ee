"""Principal components of vertex positions."""

import numpy as np

from caricli.geometry.per_column import per_column
from caricli.models.principal_components import principal_components
from caricli.models.prior import Prior


class PcaModel:
    """vertices = mean + latent @ basis; a latent is in standard deviations of the training shapes."""

    kind = "pca"

    def __init__(self, template, mean, basis, model_id=""):
        """template: Template. mean: (V, 3). basis: (D, V, 3) metres at one standard deviation."""
        self.template, self.mean, self.basis, self.model_id = template, mean, basis, model_id
        self.prior = Prior.standard(len(basis))
        flat = basis.reshape(len(basis), -1)
        self._encoder = np.linalg.solve(flat @ flat.T, flat)

    @classmethod
    def train(cls, template, shapes, dimension=128, seed=0):
        """Fit to shapes (N, V, 3)."""
        mean, basis, _ = principal_components(shapes.reshape(len(shapes), -1), dimension, seed)
        return cls(template, mean.reshape(-1, 3).astype(float), basis.reshape(len(basis), -1, 3).astype(float))

    @classmethod
    def from_tensors(cls, template, tensors, model_id):
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        mean, basis = tensors["mean"].astype(float), tensors["basis"].astype(float)
        if mean.shape != template.vertices.shape or basis.shape[1:] != mean.shape:
            raise ValueError(f"mean {mean.shape}, basis {basis.shape} for {len(template.vertices)} vertices")
        return cls(template, mean, basis, model_id)

    def tensors(self):
        """See ShapeModel."""
        return {"mean": self.mean.astype(np.float32), "basis": self.basis.astype(np.float16)}

    def prepare(self):
        """See ShapeModel: the fits need nothing beyond what is here."""

    def decode(self, latents):
        """See ShapeModel."""
        return self.mean + np.tensordot(latents, self.basis, 1)

    def decode_on(self, latents, matrix):
        """See ShapeModel."""
        return per_column(matrix, self.decode(latents))

    def decode_points(self, latent, points):
        """See ShapeModel."""
        return self.mean[points] + np.tensordot(latent, self.basis[:, points], 1)

    def points_jacobian(self, latent, points):
        """See ShapeModel."""
        return self.decode_points(latent, points), np.moveaxis(self.basis[:, points], 0, -1)

    def encode(self, vertices):
        """See ShapeModel: the orthogonal projection."""
        return (vertices - self.mean).reshape(*vertices.shape[:-2], -1) @ self._encoder.T
