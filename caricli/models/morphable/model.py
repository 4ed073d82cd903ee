"""A linear morphable model: identity, expression and albedo in bases of their own."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from caricli.models.linear_basis import LinearBasis
from caricli.models.linear_model import LinearModel
from caricli.models.morphable.config import MorphableConfig
from caricli.models.morphable.separate import principal_directions, separate
from caricli.models.principal_components import principal_components
from caricli.template.template import Template

_DIMENSIONS = {"mean": 2, "identity": 3, "expression": 3, "albedo_mean": 2, "albedo": 3}


@dataclass(frozen=True, eq=False)
class MorphableShapes:
    """What a morphable model is trained with.

    vertices: (N, V, 3) metres. people, expressions: (N,) ints, who and which expression. albedos: (M, V, 3) uint8 sRGB,
    of anyone.
    """

    vertices: np.ndarray
    people: np.ndarray
    expressions: np.ndarray
    albedos: np.ndarray


@dataclass(frozen=True, eq=False)
class ShapeBases:
    """Bases of identity and expression about one mean.

    mean: (V, 3). identity: (I, V, 3), expression: (E, V, 3), metres at one standard deviation. noise: metres, how far a
    coordinate is expected from what the bases make of it.
    """

    mean: np.ndarray
    identity: np.ndarray
    expression: np.ndarray
    noise: float


class MorphableModel(LinearModel):
    """vertices = mean + identity and expression bases (portrait paper, equation 1); colours likewise (equation 2).

    A latent is the identity's coefficients, then the expression's, all in standard deviations. Encoding finds the
    likeliest one: the bases overlap, and without the prior a large expression and its opposite identity would share one
    shape.
    """

    kind = "morphable"

    def __init__(self, template: Template, bases: ShapeBases, albedo: LinearBasis) -> None:
        """albedo: sRGB from 0 to 1."""
        both = np.concatenate([bases.identity, bases.expression])
        super().__init__(template, LinearBasis(bases.mean, both), bases.noise)
        self.identity = bases.identity
        self.expression = bases.expression
        self.noise = bases.noise
        self.albedo = albedo

    @classmethod
    def train(cls, template: Template, shapes: MorphableShapes, config: MorphableConfig) -> Self:
        """Separate who from what (see ``separate``) and take principal components of each, fewer where there are fewer.

        Raises NumericsError when all shapes, or all albedos, are the same.
        """
        rows = shapes.vertices.reshape(len(shapes.vertices), -1)
        faces, offsets = separate(rows, shapes.people, shapes.expressions, config.identity, config.seed)
        mean, identity, _ = principal_components(faces, config.identity, config.seed)
        colours = shapes.albedos.reshape(len(shapes.albedos), -1) / 255.0
        albedo_mean, albedo, _ = principal_components(colours, config.albedo, config.seed)
        expression = principal_directions(offsets, config.expression, config.seed)

        def at_vertices(values: np.ndarray) -> np.ndarray:
            return values.astype(float).reshape(*values.shape[:-1], *template.vertices.shape)

        noise = config.noise * template.height
        bases = ShapeBases(at_vertices(mean), at_vertices(identity), at_vertices(expression), noise)
        return cls(template, bases, LinearBasis(at_vertices(albedo_mean), at_vertices(albedo)))

    @classmethod
    def from_tensors(cls, template: Template, tensors: Mapping[str, np.ndarray]) -> Self:
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        values = {name: tensors[name].astype(float) for name in _DIMENSIONS}
        for name, value in values.items():
            if value.ndim != _DIMENSIONS[name] or value.shape[-2:] != template.vertices.shape:
                raise ValueError(f"{name} {value.shape} for {len(template.vertices)} vertices")
        noise = float(tensors["noise"])
        if noise <= 0:
            raise ValueError(f"noise {noise}")
        bases = ShapeBases(values["mean"], values["identity"], values["expression"], noise)
        return cls(template, bases, LinearBasis(values["albedo_mean"], values["albedo"]))

    def tensors(self) -> dict[str, np.ndarray]:
        """See ShapeModel."""
        return {
            "mean": self.mean.astype(np.float32),
            "albedo_mean": self.albedo.mean.astype(np.float32),
            "identity": self.identity.astype(np.float16),
            "expression": self.expression.astype(np.float16),
            "albedo": self.albedo.basis.astype(np.float16),
            "noise": np.array(self.noise, np.float32),
        }

    def parts(self, latents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The identity's (..., I) and the expression's coefficients (..., E) of latents."""
        return latents[..., : len(self.identity)], latents[..., len(self.identity) :]

    def colours(self, coefficients: np.ndarray) -> np.ndarray:
        """Colours (..., V, 3) sRGB from 0 to 1 of albedo coefficients (..., A) (equation 2)."""
        return np.clip(self.albedo.combine(coefficients), 0, 1)
