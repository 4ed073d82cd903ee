"""Principal components of deformation-gradient features, decoded by a sparse solve: they extrapolate untorn."""

import igl
import numpy as np

from caricli.geometry.deformation_gradients import FEATURES
from caricli.geometry.elastic_anchors import ElasticAnchors
from caricli.geometry.per_column import per_column
from caricli.models.principal_components import principal_components
from caricli.models.prior import Prior

_BATCH = 32


class IntrinsicModel:
    """features = mean + latent @ basis, then DeformationGradients; a latent is in training standard deviations.

    The features do not hold the translation; it is a linear function of the latent, the offset of the centroid.
    """

    kind = "intrinsic"

    def __init__(self, template, mean, basis, offset, model_id=""):
        """template: Template. mean: (V, 9). basis: (D, V, 9) per standard deviation. offset: (D + 1, 3) metres."""
        self.template, self.mean, self.basis, self.offset, self.model_id = template, mean, basis, offset, model_id
        self.prior = Prior.standard(len(basis))
        weight = feature_weights(template)
        flat = basis.reshape(len(basis), -1)
        self._weighted = flat * np.repeat(weight, FEATURES)
        self._gram = self._weighted @ flat.T
        self._known, self._rows, self._anchors = np.zeros(0, dtype=np.int64), None, None

    @classmethod
    def train(cls, template, shapes, dimension=128, seed=0):
        """Fit to shapes (N, V, 3)."""
        batches = (shapes[k : k + _BATCH] for k in range(0, len(shapes), _BATCH))
        features = np.concatenate([template.gradients.features(batch).astype(np.float32) for batch in batches])
        scale = np.sqrt(feature_weights(template)).astype(np.float32)[:, None]
        features *= scale
        mean, basis, _ = principal_components(features.reshape(len(shapes), -1), dimension, seed)
        mean, basis = mean.reshape(-1, FEATURES) / scale, basis.reshape(len(basis), -1, FEATURES) / scale
        model = cls(template, mean.astype(float), basis.astype(float), np.zeros((len(basis) + 1, 3)))
        latents = np.array([model.features_to_latent(f / scale) for f in features])
        design = np.hstack([np.ones((len(latents), 1)), latents])
        # A ridge: with fewer shapes than unknowns the offsets would explode.
        gram = design.T @ design + 1e-3 * len(latents) * np.diag(np.r_[0.0, np.ones(len(basis))])
        model.offset = np.linalg.solve(gram, design.T @ shapes.mean(1))
        return model

    @classmethod
    def from_tensors(cls, template, tensors, model_id):
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        mean, basis, offset = (tensors[name].astype(float) for name in ("mean", "basis", "offset"))
        count = len(template.vertices)
        if mean.shape != (count, FEATURES) or basis.shape[1:] != mean.shape or offset.shape != (len(basis) + 1, 3):
            raise ValueError(f"mean {mean.shape}, basis {basis.shape}, offset {offset.shape} for {count} vertices")
        return cls(template, mean, basis, offset, model_id)

    def tensors(self):
        """See ShapeModel."""
        return {
            "mean": self.mean.astype(np.float32),
            "basis": self.basis.astype(np.float16),
            "offset": self.offset.astype(np.float32),
        }

    @property
    def anchors(self):
        """ElasticAnchors for every vertex that a landmark can stand on, prepared on first use."""
        if self._anchors is None:
            template = self.template
            self._anchors = ElasticAnchors(template.vertices, template.faces, template.annotation.anchor_ids())
        return self._anchors

    def prepare(self):
        """See ShapeModel."""
        _ = self.anchors, self.template.gradients, self.template.cavities

    def features(self, latents):
        """Latents (..., D) to features (..., V, 9)."""
        return self.mean + np.tensordot(latents, self.basis, 1)

    def features_to_latent(self, features, shrink=0.0):
        """Project features (..., V, 9) into the space.

        Minimises ``|f - mean - z @ basis|_W^2 + shrink |z|^2`` (W area weights that sum to one) over z.
        """
        right = (features - self.mean).reshape(*features.shape[:-2], -1) @ self._weighted.T
        return np.linalg.solve(self._gram + shrink * np.eye(len(self._gram)), right[..., None])[..., 0]

    def decode(self, latents, residual=0.0):
        """See ShapeModel; residual: (..., V, 9) features added to those of the latent."""
        latents = np.asarray(latents)
        batch = latents.shape[:-1]
        residuals = np.broadcast_to(residual, (*batch, *self.mean.shape))
        shapes = np.empty((*batch, *self.template.vertices.shape))
        # One by one: the features of a large batch would need much memory.
        for k in np.ndindex(batch):
            shapes[k] = self.template.gradients.vertices(self.features(latents[k]) + residuals[k])
        return shapes + self._centroid(latents)[..., None, :]

    def decode_on(self, latents, matrix):
        """See ShapeModel."""
        return per_column(matrix, self.decode(latents))

    def _centroid(self, latents):
        return self.offset[0] + latents @ self.offset[1:]

    def decode_points(self, latent, points):
        """See ShapeModel."""
        planes, _ = self.template.gradients.planes_jacobian(self.features(latent), self.basis[:0])
        return self._rows_of(points) @ planes.reshape(-1, 3) + self._centroid(latent)

    def points_jacobian(self, latent, points):
        """See ShapeModel."""
        planes, jacobian = self.template.gradients.planes_jacobian(self.features(latent), self.basis)
        rows, dimension = self._rows_of(points), len(latent)
        positions = rows @ planes.reshape(-1, 3) + self._centroid(latent)
        derivative = (rows @ jacobian.reshape(-1, 3 * dimension)).reshape(len(rows), 3, dimension)
        return positions, derivative + self.offset[1:].T

    def _rows_of(self, points):
        """The rows of the solution that are asked for, kept for later calls for the same points or some of them."""
        points, gradients = np.asarray(points, dtype=np.int64), self.template.gradients
        if not np.isin(points, self._known).all():
            self._known = np.unique(points)
            unit = np.zeros((gradients.count, len(self._known)))
            unit[self._known, np.arange(len(self._known))] = 1
            responses = gradients.solve(unit - 1 / gradients.count)
            self._rows = np.asarray((gradients.divergence.T @ responses).T)
        return self._rows[np.searchsorted(self._known, points)]

    def encode(self, vertices):
        """See ShapeModel: the projection of the features."""
        return self.features_to_latent(self.template.gradients.features(vertices))


def feature_weights(template):
    """(V,) share of the template's area around every vertex."""
    areas = igl.massmatrix(template.vertices, template.faces).diagonal()
    return areas / areas.sum()
