"""Light on skin with folds: its normals bend, and what lies deep is darker and redder."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.creases.relief import Relief
from caricli.methods.texture.estimate_light import harmonics
from caricli.template.fine_mesh import FineMesh

STAIN = np.array([0.75, 1.0, 1.05])
"""How much of a stain red, green and blue take: red the least."""

_COSINE = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4], [1, 3, 5])
"""Of a wide light's harmonics, by which a matt surface dims each (Ramamoorthi and Hanrahan 2001)."""

_FLATTEST = 0.15  # of the usual face's own area: what is seen more from the side has no folds
_STEEPEST = 1.4  # slope of a fold's wall
_DARKEST = 0.15  # of the mean light
_RANGE = (0.45, 1.6)  # of the light that a wall gets, by that without folds


class CreaseGround:
    """Where folds can be in the skin of a topology, prepared once."""

    def __init__(self, fine: FineMesh, places: np.ndarray, least: float) -> None:
        """fine: FineMesh of the skin. places: (P, 3) of its vertices on the usual face, in widths. least: height
        of places towards the front, below which there are no folds."""
        self.faces = fine.mesh.faces
        self.places = places[:, :2]
        corners = places[self.faces]
        flat = (corners[:, 1:] - corners[:, :1])[..., :2]
        areas = np.linalg.det(flat)
        whole = np.linalg.norm(np.cross(*np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 0)), axis=1)
        self.front = (areas > _FLATTEST * whole) & (corners[..., 2].min(1) > least)
        self.inverse = np.zeros_like(flat)
        self.inverse[self.front] = np.linalg.inv(flat[self.front])


@dataclass(frozen=True, eq=False)
class CreasedSkin:
    """Folds in the skin of a face. ground: CreaseGround. relief: Relief. steps: (F, 2, 3), by which slopes on the
    usual face become those of this one, in its own frame."""

    ground: CreaseGround
    relief: Relief
    steps: np.ndarray

    @staticmethod
    def of(ground: CreaseGround, relief: Relief, vertices: np.ndarray, unit: float) -> "CreasedSkin":
        """Folds on a face of the fine mesh's vertices (P, 3) metres. unit: metres of a width of the face."""
        corners = vertices[ground.faces[ground.front]]
        along = ground.inverse[ground.front] @ (corners[:, 1:] - corners[:, :1])
        # Slopes of a function on the flat usual face, as a vector in the plane of the triangle.
        inner = along @ along.transpose(0, 2, 1) + 1e-12 * np.eye(2)
        steps = np.zeros((len(ground.faces), 2, 3))
        steps[ground.front] = unit * np.linalg.solve(inner, along)
        return CreasedSkin(ground, relief, steps)

    def brightness(
        self, triangles: np.ndarray, weights: np.ndarray, normals: np.ndarray, light: np.ndarray
    ) -> np.ndarray:
        """(N, 3) factors of linear light of pixels.

        triangles: (N,) of the fine mesh. weights: (N, 3) of their corners. normals: (N, 3) unit. light: (9, 3)
        spherical harmonics; both in the face's own frame.
        """
        places = np.einsum("nk,nkc->nc", weights, self.ground.places[self.ground.faces[triangles]])
        slopes, stain = self.relief.at(places)
        drawn = (np.abs(slopes).max(1) > 1e-3) & self.ground.front[triangles]
        factors = np.ones((len(triangles), 3), np.float32)
        bend = np.einsum("nk,nkc->nc", slopes[drawn], self.steps[triangles[drawn]])
        size = np.linalg.norm(bend, axis=1, keepdims=True)
        bend *= np.tanh(size / _STEEPEST) * _STEEPEST / np.maximum(size, 1e-9)
        flat = normals[drawn]
        bent = flat - bend
        bent /= np.linalg.norm(bent, axis=1, keepdims=True)
        dim = _COSINE[:, None] * light
        floor = _DARKEST * np.pi * light[0] * harmonics(np.array([[0.0, 0.0, 1.0]]))[0, 0]
        before, after = (np.maximum(harmonics(way) @ dim, 0) + floor for way in (flat, bent))
        factors[drawn] = np.clip(after / before, *_RANGE)
        return factors * np.exp(-stain[:, None] * self.ground.front[triangles, None] * STAIN)
