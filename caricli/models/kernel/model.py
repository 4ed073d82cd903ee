"""Principal components of vertex positions, the finer ones predicted from the coarser ones by a Gaussian process."""

from collections.abc import Mapping
from functools import partial
from typing import Self

import numpy as np
from scipy.sparse import csr_matrix

from caricli.geometry.gauss_newton import gauss_newton
from caricli.geometry.per_column import per_column
from caricli.models.kernel.config import KernelConfig
from caricli.models.kernel.gaussian_process import GaussianProcess, gaussian_kernel
from caricli.models.linear_basis import direction_products
from caricli.models.model_id import NamedByWeights
from caricli.models.principal_components import principal_components
from caricli.models.prior import Prior
from caricli.structures import SeenPeople
from caricli.template.template import Template

# Three steps take what was decoded back to its latent to about 1e-8.
_STEPS = 3
# Keeps the Gaussian process solvable where a centre comes twice.
_JITTER = 1e-4
# How many shapes the mean face counts for, which is to stay what it is: its own mean would be a less exaggerated face.
_MEAN_FACES = 1e4


class KernelModel(NamedByWeights):
    """vertices = mean + [latent, g(latent)] @ basis; a latent is in standard deviations of the training shapes.

    The latent holds the first D coefficients of a shape, the GaussianProcess g predicts the E finer ones. Far from the
    training shapes g fades away, and the model goes on linearly.
    """

    kind = "kernel"
    seen: SeenPeople | None = None

    def __init__(self, template: Template, mean: np.ndarray, basis: np.ndarray, process: GaussianProcess) -> None:
        """mean: (V, 3) metres. basis: (D + E, V, 3) metres at one standard deviation. process: of D to E numbers."""
        self.template = template
        self.mean = mean
        self.basis = basis
        self.process = process
        self.prior = Prior.standard(len(process.scale))
        flat = basis.reshape(len(basis), -1)
        self._gram = direction_products(flat)

    @classmethod
    def train(cls, template: Template, shapes: np.ndarray, config: KernelConfig) -> Self:
        """Fit to shapes (N, V, 3) metres and their mirror images. Raises NumericsError when all are the same."""
        rows = with_mirror_images(shapes, template.annotation.mirror)
        root = np.sqrt(vertex_weights(template, config.near, config.radius)).astype(rows.dtype)[:, None]
        rows = (rows * root).reshape(len(rows), -1)
        mean, basis, _ = principal_components(rows, config.components, config.seed)
        deviations = np.linalg.norm(basis, axis=1)
        coefficients = ((rows - mean) @ (basis / deviations[:, None] ** 2).T).astype(float)
        process = train_process(coefficients, deviations, config)
        mean = mean.reshape(-1, 3) / root
        basis = basis.reshape(len(basis), -1, 3) / root
        return cls(template, mean.astype(float), basis.astype(float), process)

    @classmethod
    def from_tensors(cls, template: Template, tensors: Mapping[str, np.ndarray]) -> Self:
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        names = ("mean", "basis", "scale", "centres", "weights")
        mean, basis, scale, centres, weights = (tensors[name].astype(float) for name in names)
        fits = (
            mean.shape == template.vertices.shape == basis.shape[1:]
            and scale.ndim == 1
            and centres.shape == (len(centres), len(scale))
            and weights.shape == (len(centres), len(basis) - len(scale))
        )
        if not fits:
            shapes = ", ".join(f"{name} {tensors[name].shape}" for name in names)
            raise ValueError(f"{shapes} for {len(template.vertices)} vertices")
        return cls(template, mean, basis, GaussianProcess(scale, centres, weights))

    def tensors(self) -> dict[str, np.ndarray]:
        """See ShapeModel."""
        return {
            "basis": self.basis.astype(np.float16),
            "centres": self.process.centres.astype(np.float16),
            "weights": self.process.weights.astype(np.float16),
            "mean": self.mean.astype(np.float32),
            "scale": self.process.scale.astype(np.float32),
        }

    def prepare(self) -> None:
        """See ShapeModel: the fits need nothing beyond what is here."""

    def coefficients(self, latents: np.ndarray) -> np.ndarray:
        """Latents (..., D) to the coefficients (..., D + E) of all components."""
        latents = np.asarray(latents)
        return np.concatenate([latents, self.process.predict(latents)], axis=-1)

    def _jacobian(self, latent: np.ndarray) -> np.ndarray:
        """Derivatives (D + E, D) of the coefficients by the latent (D,)."""
        return np.concatenate([np.eye(len(latent)), self.process.jacobian(latent)])

    def decode(self, latents: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        return self.mean + np.tensordot(self.coefficients(latents), self.basis, 1)

    def decode_on(self, latents: np.ndarray, matrix: csr_matrix) -> np.ndarray:
        """See ShapeModel."""
        return per_column(matrix, self.decode(latents))

    def decode_points(self, latent: np.ndarray, points: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        return self.mean[points] + np.tensordot(self.coefficients(latent), self.basis[:, points], 1)

    def points_jacobian(self, latent: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ShapeModel."""
        basis = self.basis[:, points]
        positions = self.mean[points] + np.tensordot(self.coefficients(latent), basis, 1)
        return positions, np.tensordot(basis, self._jacobian(latent), (0, 0))

    def encode(self, vertices: np.ndarray) -> np.ndarray:
        """See ShapeModel: the projection on the first components, then Gauss-Newton steps to the nearest shape.

        Minimises ``|coefficients(z) @ basis - (vertices - mean)|^2`` over z, in the space of the coefficients.
        """
        count = len(self.prior.mean)
        gram = self._gram
        products = (vertices - self.mean).reshape(*vertices.shape[:-2], -1) @ self.basis.reshape(len(gram), -1).T
        latents = np.linalg.solve(gram[:count, :count], products[..., :count, None])[..., 0]
        for k in np.ndindex(latents.shape[:-1]):
            equations = partial(self._normal_equations, products[k])
            latents[k] = gauss_newton(latents[k], equations, _STEPS)
        return latents

    def _normal_equations(self, products: np.ndarray, latent: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """System (D, D) and right side (D,) of a step from a latent. products: (D + E,) of a shape with the basis."""
        jacobian = self._jacobian(latent)
        residual = products - self._gram @ self.coefficients(latent)
        return jacobian.T @ self._gram @ jacobian, jacobian.T @ residual


def train_process(coefficients: np.ndarray, deviations: np.ndarray, config: KernelConfig) -> GaussianProcess:
    """Predict the finer coefficients of shapes from the coarser ones.

    A sparse Gaussian process, the subset of regressors (Quiñonero-Candela and Rasmussen 2005, section 4), whose centres
    are random training latents. Minimises ``|K_nm W - Y|^2 + ridge tr(W' K_mm W)`` over the weights W, with the mean
    face among the rows.

    coefficients: (N, D + E) of the training shapes, in standard deviations. deviations: (D + E,) metres.
    """
    from scipy.linalg import solve

    latents, finer = np.split(coefficients, [config.dimension], axis=1)
    # Coarse components matter more. A typical latent has the length 1 / width.
    scale = np.sqrt(deviations[: latents.shape[1]])
    scale /= np.linalg.norm(scale) * config.width
    chosen = np.random.default_rng(config.seed).permutation(len(latents))[: config.centres]
    centres = latents[chosen] * scale
    kernel = gaussian_kernel(latents * scale, centres)
    between_centres = gaussian_kernel(centres, centres)
    at_mean = gaussian_kernel(0 * scale, centres)
    system = kernel.T @ kernel + config.ridge * (between_centres + _JITTER * np.eye(len(centres)))
    system += _MEAN_FACES * np.outer(at_mean, at_mean)
    return GaussianProcess(scale, centres, solve(system, kernel.T @ finer, assume_a="pos"))


def with_mirror_images(shapes: np.ndarray, mirror: np.ndarray | None) -> np.ndarray:
    """Shapes (N, V, 3) and, where mirror (V,) is given, their images in the plane x = 0: (2 N, V, 3)."""
    if mirror is None:
        return shapes
    return np.concatenate([shapes, shapes[:, mirror] * shapes.dtype.type([-1, 1, 1])])


def vertex_weights(template: Template, near: float, radius: float) -> np.ndarray:
    """(V,) ``1 + near exp(-(d / radius)^2)``, d the distance to the nearest landmark as a share of the head's height.

    What landmarks see then takes little of the prior's distance to reach.
    """
    from scipy.spatial import KDTree

    distance, _ = KDTree(template.vertices[template.annotation.landmarks]).query(template.vertices)
    return 1 + near * np.exp(-((distance / template.height / radius) ** 2))
