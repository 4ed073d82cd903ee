"""Principal components of vertex positions."""

from collections.abc import Mapping
from typing import Self

import numpy as np

from caricli.models.linear_basis import LinearBasis
from caricli.models.linear_model import LinearModel
from caricli.models.pca.config import PcaConfig
from caricli.models.principal_components import principal_components
from caricli.template.template import Template


class PcaModel(LinearModel):
    """A LinearModel whose basis are the principal components of the shapes; encoding is the orthogonal projection."""

    kind = "pca"

    def __init__(self, template: Template, mean: np.ndarray, basis: np.ndarray) -> None:
        """mean: (V, 3) metres. basis: (D, V, 3) metres at one standard deviation."""
        super().__init__(template, LinearBasis(mean, basis))

    @classmethod
    def train(cls, template: Template, shapes: np.ndarray, config: PcaConfig) -> Self:
        """Fit to shapes (N, V, 3) metres. Raises NumericsError when all of them are the same."""
        rows = shapes.reshape(len(shapes), -1)
        mean, basis, _ = principal_components(rows, config.dimension, config.seed)
        return cls(template, mean.reshape(-1, 3).astype(float), basis.reshape(len(basis), -1, 3).astype(float))

    @classmethod
    def from_tensors(cls, template: Template, tensors: Mapping[str, np.ndarray]) -> Self:
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        mean = tensors["mean"].astype(float)
        basis = tensors["basis"].astype(float)
        if mean.shape != template.vertices.shape or basis.shape[1:] != mean.shape:
            raise ValueError(f"mean {mean.shape}, basis {basis.shape} for {len(template.vertices)} vertices")
        return cls(template, mean, basis)

    def tensors(self) -> dict[str, np.ndarray]:
        """See ShapeModel."""
        return {"mean": self.mean.astype(np.float32), "basis": self.basis.astype(np.float16)}
