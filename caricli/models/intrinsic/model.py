"""Principal components of deformation-gradient features, decoded by a sparse solve: they extrapolate untorn."""

from collections.abc import Mapping
from functools import cached_property, partial
from typing import Self

import igl
import numpy as np
from scipy.sparse import csr_matrix

from caricli.errors import InputError
from caricli.geometry.per_column import per_column
from caricli.io.kept import kept_arrays
from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.linear_basis import direction_products
from caricli.models.model_id import NamedByWeights
from caricli.models.principal_components import principal_components
from caricli.models.prior import Prior
from caricli.structures import SeenPeople
from caricli.structures.face import FEATURES
from caricli.template.template import Template

_BATCH = 32
"""Shapes whose features are computed at once: all of a dataset's would need much memory."""

_OFFSET_RIDGE = 1e-3
"""Of the regression of the offsets, a share of the latents' variance: with fewer shapes than unknowns they explode."""


class IntrinsicModel(NamedByWeights):
    """features = mean + latent @ basis, then DeformationGradients; a latent is in training standard deviations.

    The features do not hold where components are; how far each is moved is a linear function of the latent.
    """

    kind = "intrinsic"
    seen: SeenPeople | None = None

    def __init__(self, template: Template, mean: np.ndarray, basis: np.ndarray, offset: np.ndarray) -> None:
        """mean: (V, 9). basis: (D, V, 9) per standard deviation. offset: (D + 1, 3 C) metres, of C components."""
        self.template = template
        self.mean = mean
        self.basis = basis
        self.offset = offset
        self._labels = template.gradients.components.labels
        self.prior = Prior.standard(len(basis))
        direction_products(basis.reshape(len(basis), -1))
        # The vertices whose rows of the solution are kept, in ascending order, and these rows.
        self._kept_points = np.zeros(0, dtype=np.int64)
        self._kept_rows = np.zeros((0, 0))
        # The last latents and their features, the newest last.
        self._asked: list[tuple[bytes, np.ndarray]] = []

    @classmethod
    def train(cls, template: Template, shapes: np.ndarray, config: IntrinsicConfig) -> Self:
        """Fit to shapes (N, V, 3) metres. Raises NumericsError when all of them are the same."""
        batches = (shapes[k : k + _BATCH] for k in range(0, len(shapes), _BATCH))
        features = np.concatenate([template.gradients.features(batch).astype(np.float32) for batch in batches])
        scale = np.sqrt(feature_weights(template)).astype(np.float32)[:, None]
        features *= scale
        mean, basis, _ = principal_components(features.reshape(len(shapes), -1), config.dimension, config.seed)
        mean = mean.reshape(-1, FEATURES) / scale
        basis = basis.reshape(len(basis), -1, FEATURES) / scale
        components = template.gradients.components
        still = np.zeros((len(basis) + 1, 3 * components.count))
        model = cls(template, mean.astype(float), basis.astype(float), still)
        latents = np.array([model.features_to_latent(f / scale) for f in features])
        design = np.hstack([np.ones((len(latents), 1)), latents])
        gram = design.T @ design + _OFFSET_RIDGE * len(latents) * np.diag(np.r_[0.0, np.ones(len(basis))])
        missing = np.array([model._missing(*pair) for pair in zip(shapes, latents, strict=True)])
        model.offset = np.linalg.solve(gram, design.T @ missing.reshape(len(missing), -1))
        return model

    @classmethod
    def from_tensors(cls, template: Template, tensors: Mapping[str, np.ndarray]) -> Self:
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        mean, basis, offset = (tensors[name].astype(float) for name in ("mean", "basis", "offset"))
        count = len(template.vertices)
        places = (len(basis) + 1, 3 * template.gradients.components.count)
        if mean.shape != (count, FEATURES) or basis.shape[1:] != mean.shape or offset.shape != places:
            raise ValueError(f"mean {mean.shape}, basis {basis.shape}, offset {offset.shape} for {count} vertices")
        return cls(template, mean, basis, offset)

    def tensors(self) -> dict[str, np.ndarray]:
        """See ShapeModel."""
        return {
            "mean": self.mean.astype(np.float32),
            "basis": self.basis.astype(np.float16),
            "offset": self.offset.astype(np.float32),
        }

    @cached_property
    def _weighted(self) -> np.ndarray:
        """(D, 9 V) the basis, weighted by area."""
        return self.basis.reshape(len(self.basis), -1) * np.repeat(feature_weights(self.template), FEATURES)

    @cached_property
    def _gram(self) -> np.ndarray:
        """(D, D) weighted products of the directions."""
        return direction_products(self.basis.reshape(len(self.basis), -1), self._weighted)

    @cached_property
    def tangent(self) -> np.ndarray:
        """(A, 3, D) derivatives by the latent, at the mean face, of the points of the template's ``anchors``."""
        template = self.template
        points = template.annotation.anchor_ids()
        given = (template.vertices, template.faces, points, self.mean, self.offset, self.model_id)
        return kept_arrays("tangent", given, partial(self._tangent_at, points))["tangent"]

    def _tangent_at(self, points: np.ndarray) -> Mapping[str, np.ndarray]:
        return {"tangent": self.points_jacobian(self.prior.mean, points)[1]}

    def prepare(self) -> None:
        """See ShapeModel."""
        template = self.template
        _ = self.tangent, template.anchors, template.gradients, template.cavities, template.neck

    def features(self, latents: np.ndarray) -> np.ndarray:
        """Latents (..., D) to features (..., V, 9), which are not to be written to."""
        latents = np.asarray(latents, float)
        if latents.ndim != 1:
            return self.mean + np.tensordot(latents, self.basis, 1)
        # Fits ask several times for the same ones, and reading the basis takes longest.
        key = latents.tobytes()
        features = next((features for asked, features in self._asked if asked == key), None)
        if features is None:
            features = self.mean + np.tensordot(latents, self.basis, 1)
            features.flags.writeable = False
        self._asked = [*(pair for pair in self._asked if pair[0] != key)][-1:] + [(key, features)]
        return features

    def features_to_latent(self, features: np.ndarray, shrink: float = 0.0) -> np.ndarray:
        """Project features (..., V, 9) into the space.

        Minimises ``|f - mean - z @ basis|_W^2 + shrink |z|^2`` (W area weights that sum to one) over z.
        """
        right = (features - self.mean).reshape(*features.shape[:-2], -1) @ self._weighted.T
        return np.linalg.solve(self._gram + shrink * np.eye(len(self._gram)), right[..., None])[..., 0]

    def decode(self, latents: np.ndarray, residual: np.ndarray | float = 0.0) -> np.ndarray:
        """See ShapeModel; residual: (..., V, 9) features added to those of the latent."""
        latents = np.asarray(latents)
        batch = latents.shape[:-1]
        residuals = np.broadcast_to(residual, (*batch, *self.mean.shape))
        shapes = np.empty((*batch, *self.template.vertices.shape))
        # One by one: the features of a large batch would need much memory.
        for k in np.ndindex(batch):
            shapes[k] = self.template.gradients.vertices(self.features(latents[k]) + residuals[k])
        return shapes + self._offsets(latents)[..., self._labels, :]

    def decode_on(self, latents: np.ndarray, matrix: csr_matrix) -> np.ndarray:
        """See ShapeModel."""
        return per_column(matrix, self.decode(latents))

    def _offsets(self, latents: np.ndarray) -> np.ndarray:
        """(..., C, 3) how far the components are from where features alone put them."""
        return (self.offset[0] + latents @ self.offset[1:]).reshape(*latents.shape[:-1], self._labels.max() + 1, 3)

    def _missing(self, shape: np.ndarray, latent: np.ndarray) -> np.ndarray:
        """(C, 3) what the offsets of a shape (V, 3) are to be."""
        components = self.template.gradients.components
        if components.count == 1:
            return shape.mean(0, keepdims=True)
        return components.averages @ (shape - self.template.gradients.vertices(self.features(latent)))

    def decode_points(self, latent: np.ndarray, points: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        planes, _ = self.template.gradients.planes_jacobian(self.features(latent), self.basis[:0])
        return self._rows_of(points) @ planes.reshape(-1, 3) + self._offsets(latent)[self._labels[points]]

    def points_jacobian(self, latent: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ShapeModel."""
        planes, jacobian = self.template.gradients.planes_jacobian(self.features(latent), self.basis)
        rows = self._rows_of(points)
        dimension = len(latent)
        own = self._labels[points]
        positions = rows @ planes.reshape(-1, 3) + self._offsets(latent)[own]
        derivative = (rows @ jacobian.reshape(-1, 3 * dimension)).reshape(len(rows), 3, dimension)
        return positions, derivative + self.offset[1:].reshape(dimension, -1, 3)[:, own].transpose(1, 2, 0)

    def _rows_of(self, points: np.ndarray) -> np.ndarray:
        """The rows of the solution that are asked for, kept for later calls for the same points or some of them."""
        points = np.asarray(points, dtype=np.int64)
        if not np.isin(points, self._kept_points).all():
            gradients = self.template.gradients
            self._kept_points = np.unique(points)
            unit = np.zeros((gradients.count, len(self._kept_points)))
            unit[self._kept_points, np.arange(len(self._kept_points))] = 1
            responses = gradients.solve(unit - 1 / gradients.count)
            self._kept_rows = np.asarray((gradients.divergence.T @ responses).T)
        return self._kept_rows[np.searchsorted(self._kept_points, points)]

    def encode(self, vertices: np.ndarray) -> np.ndarray:
        """See ShapeModel: the projection of the features."""
        return self.features_to_latent(self.template.gradients.features(vertices))


def feature_weights(template: Template) -> np.ndarray:
    """(V,) share of the template's area around every vertex. Raises InputError where there is none."""
    areas = igl.massmatrix(template.vertices, template.faces).diagonal()
    if not areas.sum() > 0:
        raise InputError("expected a template with an area, found none")
    return areas / areas.sum()
