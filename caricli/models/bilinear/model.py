"""A bilinear model of faces: who somebody is times what the face does."""

from collections.abc import Mapping
from typing import Self

import numpy as np
from scipy.sparse import csr_matrix

from caricli.errors import NumericsError
from caricli.geometry.per_column import per_column
from caricli.models.bilinear.config import BilinearConfig
from caricli.models.bilinear.space import BilinearSpace
from caricli.models.model_id import NamedByWeights
from caricli.models.principal_components import MIN_SHARE
from caricli.models.prior import Prior
from caricli.structures import SeenPeople
from caricli.template.template import Template

_SAME = 1e-6
"""Faces that differ by less, relative to their largest number, are the same."""


class BilinearModel(NamedByWeights):
    """vertices = C x_2 u x_3 v (sketch paper, section 4.2); a latent is a code of a BilinearSpace.

    Its rows are coordinates in an orthonormal basis of the core's own columns, because fits and files need no more.
    """

    kind = "bilinear"
    seen: SeenPeople | None = None

    def __init__(self, template: Template, basis: np.ndarray, space: BilinearSpace) -> None:
        """basis: (R, V, 3), orthonormal up to the rounding of files. space: of R numbers, metres."""
        self.template = template
        self.basis = basis
        self.space = space
        self.prior = space.prior
        flat = basis.reshape(len(basis), -1)
        self._projector = np.linalg.solve(flat @ flat.T, flat)

    @classmethod
    def train(cls, template: Template, grid: np.ndarray, config: BilinearConfig) -> Self:
        """Fit to a grid (P, E, V, 3) metres of people with every expression.

        An exaggerated person counts as another one, as in the paper. Raises NumericsError when all faces are the same.
        """
        flat = grid.reshape(*grid.shape[:2], -1)
        if np.ptp(flat, axis=(0, 1)).max() <= _SAME * np.abs(flat[0, 0]).max():
            raise NumericsError(f"expected at least two shapes that differ, found {flat[..., 0].size} that do not")
        space = BilinearSpace.train(flat, config.identity, config.expression)
        basis, sizes, rows = np.linalg.svd(space.core.reshape(len(space.core), -1), full_matrices=False)
        kept = sizes**2 > MIN_SHARE * (sizes**2).sum()
        core = (sizes[:, None] * rows)[kept].reshape(-1, *space.core.shape[1:])
        vertices = basis.T[kept].reshape(-1, *template.vertices.shape)
        small = BilinearSpace(core, space.prior, space.noise)
        return cls(template, vertices, small.fitted_to(flat.reshape(-1, flat.shape[-1]) @ basis[:, kept]))

    @classmethod
    def from_tensors(cls, template: Template, tensors: Mapping[str, np.ndarray]) -> Self:
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        names = ("first", "basis", "core", "code", "factor", "noise")
        first, basis, core, code, factor, noise = (tensors[name].astype(float) for name in names)
        shape = template.vertices.shape
        fits = first.shape == shape and basis.shape[1:] == shape and core.ndim == 3 and len(core) == len(basis) + 1
        if not fits or noise.shape or noise <= 0:
            raise ValueError(f"first {first.shape}, basis {basis.shape}, core {core.shape} for {shape[0]} vertices")
        space = BilinearSpace(core, Prior(code, factor), float(noise))
        return cls(template, np.concatenate([first[None], basis]), space)

    def tensors(self) -> dict[str, np.ndarray]:
        """See ShapeModel. The first direction is about the mean face, which half precision would make rough."""
        return {
            "first": self.basis[0].astype(np.float32),
            "basis": self.basis[1:].astype(np.float16),
            "core": self.space.core.astype(np.float32),
            "code": self.prior.mean.astype(np.float32),
            "factor": self.prior.factor.astype(np.float32),
            "noise": np.array(self.space.noise, np.float32),
        }

    def prepare(self) -> None:
        """See ShapeModel: the fits need nothing beyond what is here."""

    def decode(self, latents: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        return np.tensordot(self.space.decode(latents), self.basis, 1)

    def decode_on(self, latents: np.ndarray, matrix: csr_matrix) -> np.ndarray:
        """See ShapeModel."""
        return per_column(matrix, self.decode(latents))

    def decode_points(self, latent: np.ndarray, points: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        return np.tensordot(self.space.decode(latent), self.basis[:, points], 1)

    def points_jacobian(self, latent: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ShapeModel."""
        jacobian = self.space.jacobian(np.asarray(latent)[None])[0]
        return self.decode_points(latent, points), np.tensordot(self.basis[:, points], jacobian, (0, 0))

    def encode(self, vertices: np.ndarray) -> np.ndarray:
        """See ShapeModel: the likeliest latent, see ``BilinearSpace.encode``."""
        rows = vertices.reshape(*vertices.shape[:-2], -1) @ self._projector.T
        return self.space.encode(rows.reshape(-1, rows.shape[-1])).reshape(*rows.shape[:-1], -1)

    def between(self, latents: np.ndarray, count: int, generator: np.random.Generator) -> np.ndarray:
        """Latents (count, D) at random places between random pairs of latents (N, D) (sketch paper, section 4.4)."""
        first, second = (latents[generator.integers(len(latents), size=count)] for _ in range(2))
        return first + generator.random((count, 1)) * (second - first)
