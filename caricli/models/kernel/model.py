"""Principal components of vertex positions, the finer ones predicted from the coarser ones by a Gaussian process."""

import numpy as np
from scipy.linalg import solve
from scipy.spatial import cKDTree

from caricli.geometry.per_column import per_column
from caricli.models.config import KernelConfig
from caricli.models.principal_components import principal_components
from caricli.models.prior import Prior

# Three steps take what was decoded back to its latent to about 1e-8.
_STEPS = 3
# Keeps the Gaussian process solvable where a centre comes twice.
_JITTER = 1e-4
# How many shapes the mean face counts for, which is to stay what it is: its own mean would be a less exaggerated face.
_MEAN_FACES = 1e4


class KernelModel:
    """vertices = mean + [latent, g(latent)] @ basis; a latent is in standard deviations of the training shapes.

    The latent holds the first D coefficients of a shape, ``g(z) = exp(-|z * scale - centres|^2 / 2) @ weights``
    predicts the E finer ones. Far from the training shapes g fades away, and the model goes on linearly.
    """

    kind = "kernel"

    def __init__(self, template, mean, basis, scale, centres, weights, model_id=""):
        """template: Template. mean: (V, 3) metres. basis: (D + E, V, 3) metres at one standard deviation.

        scale: (D,). centres: (M, D). weights: (M, E).
        """
        self.template, self.mean, self.basis, self.model_id = template, mean, basis, model_id
        self.scale, self.centres, self.weights = scale, centres, weights
        self.prior = Prior.standard(len(scale))
        flat = basis.reshape(len(basis), -1)
        self._gram = flat @ flat.T

    @classmethod
    def train(cls, template, shapes, dimension=128, **settings):
        """Fit to shapes (N, V, 3) and their mirror images; settings: the other ones of KernelConfig.

        A sparse Gaussian process, the subset of regressors (Quiñonero-Candela and Rasmussen 2005, section 4), whose
        centres are random training latents: minimises ``|K_nm W - Y|^2 + ridge tr(W' K_mm W)`` over the weights W, with
        the mean face among the rows.
        """
        config = KernelConfig(dimension, **settings)
        rows = with_mirror_images(shapes, template.annotation.mirror)
        root = np.sqrt(vertex_weights(template, config.near, config.radius)).astype(rows.dtype)[:, None]
        rows = (rows * root).reshape(len(rows), -1)
        mean, basis, _ = principal_components(rows, config.components, config.seed)
        deviations = np.linalg.norm(basis, axis=1)
        coefficients = ((rows - mean) @ (basis / deviations[:, None] ** 2).T).astype(float)
        latents, rest = np.split(coefficients, [config.dimension], axis=1)

        # Coarse components matter more. A typical latent has the length 1 / width.
        scale = np.sqrt(deviations[: latents.shape[1]])
        scale /= np.linalg.norm(scale) * config.width
        chosen = np.random.default_rng(config.seed).permutation(len(latents))[: config.centres]
        centres = latents[chosen] * scale
        kernel, own = _kernel(latents * scale, centres), _kernel(centres, centres)
        at_mean = _kernel(0 * scale, centres)
        system = kernel.T @ kernel + config.ridge * (own + _JITTER * np.eye(len(own)))
        system += _MEAN_FACES * np.outer(at_mean, at_mean)
        weights = solve(system, kernel.T @ rest, assume_a="pos")
        mean, basis = mean.reshape(-1, 3) / root, basis.reshape(len(basis), -1, 3) / root
        return cls(template, mean.astype(float), basis.astype(float), scale, centres, weights)

    @classmethod
    def from_tensors(cls, template, tensors, model_id):
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        names = ("mean", "basis", "scale", "centres", "weights")
        parts = mean, basis, scale, centres, weights = [tensors[name].astype(float) for name in names]
        sizes = (len(centres), len(scale)), (len(centres), len(basis) - len(scale))
        fits = mean.shape == template.vertices.shape == basis.shape[1:] and scale.ndim == 1
        if not fits or (centres.shape, weights.shape) != sizes:
            shapes = ", ".join(f"{name} {part.shape}" for name, part in zip(names, parts, strict=True))
            raise ValueError(f"{shapes} for {len(template.vertices)} vertices")
        return cls(template, *parts, model_id)

    def tensors(self):
        """See ShapeModel."""
        half = {name: getattr(self, name).astype(np.float16) for name in ("basis", "centres", "weights")}
        return half | {"mean": self.mean.astype(np.float32), "scale": self.scale.astype(np.float32)}

    def prepare(self):
        """See ShapeModel: the fits need nothing beyond what is here."""

    def coefficients(self, latents):
        """Latents (..., D) to the coefficients (..., D + E) of all components."""
        latents = np.asarray(latents)
        return np.concatenate([latents, _kernel(latents * self.scale, self.centres) @ self.weights], axis=-1)

    def _jacobian(self, latent):
        """Derivatives (D + E, D) of the coefficients by the latent (D,)."""
        scaled = latent * self.scale
        kernel = _kernel(scaled, self.centres)
        slopes = kernel[:, None] * (self.centres - scaled) * self.scale
        return np.concatenate([np.eye(len(latent)), self.weights.T @ slopes])

    def decode(self, latents):
        """See ShapeModel."""
        return self.mean + np.tensordot(self.coefficients(latents), self.basis, 1)

    def decode_on(self, latents, matrix):
        """See ShapeModel."""
        return per_column(matrix, self.decode(latents))

    def decode_points(self, latent, points):
        """See ShapeModel."""
        return self.mean[points] + np.tensordot(self.coefficients(latent), self.basis[:, points], 1)

    def points_jacobian(self, latent, points):
        """See ShapeModel."""
        basis = self.basis[:, points]
        positions = self.mean[points] + np.tensordot(self.coefficients(latent), basis, 1)
        return positions, np.tensordot(basis, self._jacobian(latent), (0, 0))

    def encode(self, vertices):
        """See ShapeModel: the projection on the first components, then Gauss-Newton steps to the nearest shape.

        Minimises ``|coefficients(z) @ basis - (vertices - mean)|^2`` over z, in the space of the coefficients.
        """
        count, gram = len(self.scale), self._gram
        products = (vertices - self.mean).reshape(*vertices.shape[:-2], -1) @ self.basis.reshape(len(gram), -1).T
        latents = np.linalg.solve(gram[:count, :count], products[..., :count, None])[..., 0]
        for k in np.ndindex(latents.shape[:-1]):
            for _ in range(_STEPS):
                jacobian = self._jacobian(latents[k])
                residual = products[k] - gram @ self.coefficients(latents[k])
                latents[k] += solve(jacobian.T @ gram @ jacobian, jacobian.T @ residual, assume_a="pos")
        return latents


def with_mirror_images(shapes, mirror):
    """Shapes (N, V, 3) and, where mirror (V,) is known, their images in the plane x = 0: (2 N, V, 3)."""
    return shapes if mirror is None else np.concatenate([shapes, shapes[:, mirror] * shapes.dtype.type([-1, 1, 1])])


def vertex_weights(template, near, radius):
    """(V,) ``1 + near exp(-(d / radius)^2)``, d the distance to the nearest landmark as a share of the head's height.

    What landmarks see then takes little of the prior's distance to reach.
    """
    distance, _ = cKDTree(template.vertices[template.annotation.landmarks]).query(template.vertices)
    return 1 + near * np.exp(-((distance / template.height / radius) ** 2))


def _kernel(points, centres):
    """``exp(-|p - c|^2 / 2)`` of points (..., D) and centres (M, D): (..., M)."""
    squares = (points**2).sum(-1, keepdims=True) + (centres**2).sum(-1)
    return np.exp(points @ centres.T - squares / 2)
