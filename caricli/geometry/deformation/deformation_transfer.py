"""Deformation transfer (Sumner and Popovic 2004): what happened to every triangle, done to another shape."""

import numpy as np
import scipy.sparse as sp

from caricli.errors import NumericsError
from caricli.geometry.cholesky import Cholesky
from caricli.geometry.repair.components import BOND, mesh_components
from caricli.geometry.repair.flat_triangles import flat_triangles
from caricli.geometry.triangle_normals import triangle_normals

_HOLD = 1e-8  # of the mean diagonal: makes a part definite that nothing holds, and changes nothing else


def triangle_maps(before: np.ndarray, after: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The linear map of every triangle, its normal scaled with the root of the area (portrait paper, eq. 14 and 15).

    before, after: (V, 3). faces: (F, 3), all with an area in ``before``.
    Returns (F, 3, 3).
    """
    return triangle_frames(after, faces) @ np.linalg.inv(triangle_frames(before, faces))


class DeformationTransfer:
    """Displacements of one shape whose triangles do what others did (portrait paper, eq. 16).

    Minimises ``sum_j A_j |(Q'_j - Q_j) P_j|^2`` over the displacements of the free vertices, with the area A_j of
    triangle j and the projection P_j onto its plane; held vertices do not move. A fourth vertex for each triangle, as
    published, could always be placed so that the rest of the residual vanishes, so the minimiser is the same, with a
    seventh of the unknowns. One factorisation serves all maps and coordinates. Components hang on the largest one by
    weak bonds (``mesh_components``), which stretch as they do where the maps are from.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, held: np.ndarray) -> None:
        """Factor the system.

        vertices: (V, 3). faces: (F, 3). held: (V,) bool.
        Raises NumericsError for triangles without area.
        """
        vertices = np.asarray(vertices, dtype=np.float64)
        self.faces = np.asarray(faces)
        self.count = len(vertices)
        normals = triangle_normals(vertices, self.faces)
        doubles = np.linalg.norm(normals, axis=1)
        flat = flat_triangles(vertices, self.faces)
        if flat.any():
            raise NumericsError(f"expected triangles with an area, found {flat.sum()} without")
        corners = vertices[self.faces]
        # Gradient of every corner's hat function, times the area: the opposite edge, turned in the plane, halved.
        opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
        self.slopes = np.cross(normals[:, None] / doubles[:, None, None], opposite) / 2
        cotangents = 2 * np.einsum("fad,fbd->fab", self.slopes, self.slopes) / doubles[:, None, None]
        rows = np.repeat(self.faces, 3, axis=1).ravel()
        columns = np.tile(self.faces, 3).ravel()
        laplacian = sp.csr_matrix((cotangents.ravel(), (rows, columns)), shape=(self.count, self.count))
        held = np.asarray(held, dtype=bool)
        usual = laplacian.diagonal().mean()
        self.bonds = BOND * usual * mesh_components(vertices, self.faces).stiffness(np.flatnonzero(held))
        # With nothing held it has no place of its own: a weak hold makes it definite, `displacements` places it.
        self.loose = not held.any()
        self.free = np.flatnonzero(~held)
        system = laplacian + self.bonds + _HOLD * usual * self.loose * sp.identity(self.count)
        self._factor = Cholesky(system.tocsr()[self.free][:, self.free])

    def displacements(self, triangles: np.ndarray, maps: np.ndarray, usual: np.ndarray) -> np.ndarray:
        """Displacements for the maps of some triangles; all others keep their shape.

        triangles: (m,) numbers. maps: (m, 3, 3). usual: (V, 3) displacements where the maps are from, in the size of
        this shape: its bonds stretch as they do there, and where nothing is held it goes as far as they do on average.
        Returns (V, 3).
        """
        change = maps - np.eye(3)
        forces = (change @ np.swapaxes(self.slopes[triangles], 1, 2)).transpose(1, 2, 0).reshape(3, -1)
        corners = self.faces[triangles].T.ravel()
        right = np.stack([np.bincount(corners, force, self.count) for force in forces], axis=1) + self.bonds @ usual
        moved = np.zeros((self.count, 3))
        moved[self.free] = self.solve(right[self.free])
        return moved + (usual.mean(0) - moved.mean(0)) * self.loose

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve the factored system for every column. right: (free vertices, n). Returns the same shape."""
        return self._factor.solve(right)


def triangle_frames(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F, 3, 3), in whose columns are two edges of a triangle and its normal, scaled with the root of the area.

    vertices: (V, 3). faces: (F, 3).
    """
    edges = vertices[faces[:, 1:]] - vertices[faces[:, :1]]
    frames = np.empty((len(faces), 3, 3))
    frames[:, :, :2] = edges.transpose(0, 2, 1)
    normals = np.cross(edges[:, 0], edges[:, 1])
    lengths = np.sqrt(np.maximum(np.sqrt((normals**2).sum(1)), np.finfo(float).tiny))
    frames[:, :, 2] = normals / lengths[:, None]
    return frames
