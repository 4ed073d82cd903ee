"""What a camera sees of a face."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.seen_points import seen_points
from caricli.structures import Camera, Mesh

_HIDDEN = 0.003
"""Of the head's extent, that the surface may lie before a vertex that is seen: rims of lips and lids are."""


@dataclass(frozen=True, eq=False)
class SeenStroke:
    """A stroke over a face: points (N, 2), pixels of the view of a Camera."""

    points: np.ndarray
    camera: Camera


@dataclass(frozen=True, eq=False)
class Sight:
    """A Mesh before a Camera, of any view."""

    mesh: Mesh
    camera: Camera

    @cached_property
    def pixels(self) -> np.ndarray:
        """(V, 2) where the vertices are."""
        return self.camera.project(self.mesh.vertices)

    @cached_property
    def facing(self) -> np.ndarray:
        """(V,) cosine between normals and the way to the camera."""
        return -smooth_normals(self.mesh.vertices, self.mesh.faces) @ self.camera.rotation[2]

    @cached_property
    def seen(self) -> np.ndarray:
        """(V,) bool: vertices of triangles that face the camera, which nothing hides."""
        placed = self.camera.place(self.mesh.vertices)
        turned = triangle_normals(placed, self.mesh.faces)[:, 2] < 0
        facing = np.zeros(len(placed), bool)
        facing[self.mesh.faces[turned]] = True
        slack = _HIDDEN * float(np.ptp(placed, axis=0).max())
        return facing & seen_points(placed, placed, self.mesh.faces, slack)
