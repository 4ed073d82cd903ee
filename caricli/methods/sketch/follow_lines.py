"""A surface whose curves follow drawn lines (sketch paper, section 5.1)."""

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from caricli.geometry.deformation.laplacian_deformation import LaplacianDeformation
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.settings import FollowSettings
from caricli.structures import Camera, Mesh


class LineFollower:
    """Laplacian deformation by the curves of a head, factored once for all its faces and all sets of curves.

    The displacement d of a face minimises ``|L d|^2 + w sum_k |d_k - m_k|^2`` (A^T A x = A^T b in the paper), L the
    cotangent Laplacian of the template at rest, m_k how far the handle k has to go. d is linear in m: what every handle
    alone would do is solved for once. Handles of which nothing was drawn go where no force is on them.
    """

    def __init__(self, rest: Mesh, handles: LineHandles, settings: FollowSettings = FollowSettings()) -> None:  # noqa: B008 (frozen)
        """rest: a template. handles: LineHandles of it. Raises NumericsError for triangles without area."""
        self.handles = handles
        influence = LaplacianDeformation(rest.vertices, rest.faces, handles.vertices, settings.weight).influence()
        forces = np.identity(len(handles.vertices)) - influence[handles.vertices]
        self.forces = (forces + forces.T) / 2
        # All of it is read for every face: in single precision that takes half the time.
        self.influence = influence.astype(np.float32)

    def follow(self, vertices: np.ndarray, camera: Camera, places: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) with the handles at their places in the picture, at the depth that they have.

        vertices: (V, 3). camera: Camera that sees them. places: (H, 2) pixels, NaN where nothing was drawn.
        """
        met = np.isfinite(places).all(axis=1)
        if not met.any():
            return vertices
        own = vertices[self.handles.vertices]
        moves = np.zeros_like(own)
        moves[met] = camera.lift(places[met], own[met]) - own[met]
        if not met.all():
            free = ~met
            factor = cho_factor(self.forces[np.ix_(free, free)])
            moves[free] = -cho_solve(factor, self.forces[np.ix_(free, met)] @ moves[met])
        # Nothing moves in depth, and what all handles have in common moves all vertices.
        plane = camera.rotation[:2]
        across = moves @ plane.T
        common = across.mean(0)
        return vertices + (common + self.influence @ (across - common).astype(np.float32)) @ plane
