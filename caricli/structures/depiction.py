"""How a picture shows a head."""

from dataclasses import dataclass

import numpy as np

from caricli.structures.camera import Camera
from caricli.structures.checks import coordinate_problem, refuse
from caricli.structures.landmarks import fitted_problem


@dataclass(frozen=True, eq=False)
class Depiction:
    """The picture that a head was fitted to, without its pixels.

    camera: Camera of the picture. vertices: (V, 3) float32, metres, of the head in the shape that the picture shows.
    landmarks: (68, 2) or (81, 2) pixels, where the fitted landmarks are in it, or None.
    Raises InputError when an array has another shape or holds what is not finite.
    """

    camera: Camera
    vertices: np.ndarray
    landmarks: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check the arrays."""
        vertices = np.asarray(self.vertices)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            refuse(f"depicted: expected (V,3), found {vertices.shape}")
        refuse(coordinate_problem("depicted", vertices))
        if self.landmarks is not None:
            refuse(fitted_problem(np.asarray(self.landmarks)))
