"""The numbers that make a picture of a face: who, what, which colours, light and pose."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from caricli.models.morphable.model import MorphableModel

LIGHT = 9
"""Spherical harmonics of one light without colour, as `harmonics` of the normals has them."""

POSE = 6
"""Pitch, yaw, roll (radians), place of the head's middle (2, pixels), pixels a metre."""


@dataclass(frozen=True)
class CoefficientLayout:
    """Where each part of a vector of coefficients is (portrait paper, section 3.1.2): 239 of the bundled model.

    identity, expression, albedo: how many of each; light and pose follow them.
    """

    identity: int
    expression: int
    albedo: int

    @classmethod
    def of(cls, model: MorphableModel) -> "CoefficientLayout":
        """The layout of a model's coefficients."""
        return cls(len(model.identity), len(model.expression), len(model.albedo.basis))

    @property
    def shape(self) -> int:
        """How many make the shape, which is the model's latent."""
        return self.identity + self.expression

    @property
    def face(self) -> int:
        """How many the model has, without light and pose."""
        return self.shape + self.albedo

    @property
    def size(self) -> int:
        """How many there are."""
        return self.face + LIGHT + POSE

    def parts(self, coefficients: Any) -> dict[str, Any]:
        """Views of an array or a tensor (..., size): identity, expression, albedo, light, pose."""
        ends = (0, self.identity, self.shape, self.face, self.face + LIGHT, self.size)
        names = ("identity", "expression", "albedo", "light", "pose")
        return {name: coefficients[..., ends[k] : ends[k + 1]] for k, name in enumerate(names)}

    def report(self, coefficients: np.ndarray) -> dict[str, np.ndarray]:
        """Copies of the parts of (size,), as reports have them."""
        return {name: part.copy() for name, part in self.parts(coefficients).items()}


def turned_light(light: np.ndarray, angle: float) -> np.ndarray:
    """The harmonics (9,) of a light that is turned clockwise, with the picture, by an angle in radians."""
    one, x, y, z, xy, yz, zz, xz, squares = light
    once = (np.cos(angle), np.sin(angle))
    twice = (np.cos(2 * angle), np.sin(2 * angle))
    x, y = once[0] * x - once[1] * y, once[1] * x + once[0] * y
    xz, yz = once[0] * xz - once[1] * yz, once[1] * xz + once[0] * yz
    squares, xy = twice[0] * squares - twice[1] * xy, twice[1] * squares + twice[0] * xy
    return np.array([one, x, y, z, xy, yz, zz, xz, squares])
