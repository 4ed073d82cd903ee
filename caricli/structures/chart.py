"""Where the face lies in a picture of its own."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class FaceChart:
    """The face of a mesh in the plane, from the hairline to under the chin, its eyes and nostrils holes.

    vertices: (N,) int, which of the mesh's vertices it has. faces: (G, 3) int, rows of these, those of the surface
    first. uvs: (N, 2) from 0 to 1, origin at the bottom left. membrane: (G,) bool, triangles between the inner lips,
    which the surface does not have. triangles: (G,) int, which of the mesh's triangles each is, -1 for the membrane.
    topology_id: of the mesh.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uvs: np.ndarray
    membrane: np.ndarray
    triangles: np.ndarray
    topology_id: str

    @property
    def corners(self) -> np.ndarray:
        """(G, 3) int, the mesh's vertices at the corners of the triangles."""
        return self.vertices[self.faces]
