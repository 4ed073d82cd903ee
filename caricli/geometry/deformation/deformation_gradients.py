"""Intrinsic deformation features: what happened to every one-ring, free of where it went."""

import igl
import numpy as np
import scipy.sparse as sp

from caricli.errors import NumericsError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices, rotation_vectors
from caricli.geometry.cholesky import Cholesky
from caricli.geometry.per_column import per_column
from caricli.geometry.repair.components import mesh_components

_STRETCH = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Entries of the symmetric stretch in the order of the features."""

_MIN_WEIGHT = 1e-3  # least cotangent weight: negative ones would make the system indefinite
_COLLAPSED = 1e-9  # of the template's plane, given to a ring that has none
_HOLD = 1e-11  # of the mean diagonal: what makes a system without translation definite, and changes nothing else
_LEAST_AREA = 1e-12  # of the mean: rounding gives triangles of three points in line as much
_SMALL_ANGLE = 1e-4  # radians: below it the series is exact and the closed form divides zero by zero


class DeformationGradients:
    """Vertices to nine features a vertex, and back, against one template (Wu et al. 2018, after Gao et al. 2019).

    The map of vertex i minimises ``sum_j w_ij |(v_j - v_i) - M_i (t_j - t_i)|^2`` over its one-ring, with clipped
    cotangent weights w. A one-ring is nearly flat and says nothing about what happens along its normal, so the fit is
    made in the tangent plane, ``A_i = M_i T_i`` (3x2, T_i the two main axes of the ring's normal matrix), which is
    linear in the vertices, ``A = G v``; the normal is carried to the normal of the mapped plane, scaled by the square
    root of the change of area. The polar decomposition ``M_i = exp(r_i) S_i`` gives the features: the rotation vector
    r_i (3) and the symmetric stretch minus one (6: xx, yy, zz, xy, xz, yz).

    Decoding minimises ``sum_i |(G v - A)_i sqrt(P_i)|^2``, P_i the normal matrix in the tangent plane: a sparse system
    that is factored once. Features of a real shape decode to that very shape, up to the translation of each of its
    components, which the features do not hold: the largest has its centroid at the origin with all the rest, and the
    others hang on it (``Components.hangers``).
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        """Factor the system.

        vertices: (V, 3) template. faces: (F, 3); every vertex in a triangle, every triangle with an area.
        Raises NumericsError for others.
        """
        vertices = np.asarray(vertices, dtype=np.float64)
        self.template = vertices
        self.faces = np.asarray(faces)
        self.count = len(vertices)
        i, j, weights = _weighted_edges(vertices, self.faces)
        edges = vertices[j] - vertices[i]
        metric = np.zeros((self.count, 3, 3))
        np.add.at(metric, i, weights[:, None, None] * edges[:, :, None] * edges[:, None, :])
        extent, axes = np.linalg.eigh(metric)
        axes *= np.sign(np.linalg.det(axes))[:, None, None]
        self.tangents = axes[:, :, 1:]
        self.normals = axes[:, :, 0]
        coefficients = weights[:, None] * np.einsum("ka,kab->kb", edges, self.tangents[i]) / extent[i, 1:]
        rows = (2 * i[:, None] + np.arange(2)).ravel()
        self.gradient = sp.csr_matrix(
            (
                np.r_[coefficients.ravel(), -coefficients.ravel()],
                (np.r_[rows, rows], np.r_[np.repeat(j, 2), np.repeat(i, 2)]),
            ),
            shape=(2 * self.count, self.count),
        )
        self.divergence = (self.gradient.T @ sp.diags(extent[:, 1:].ravel())).tocsr()
        self.components = mesh_components(vertices, self.faces)
        system = (self.divergence @ self.gradient).tocsc()
        self.stiffness = system.diagonal().mean()
        hangers = self.components.hangers
        # Nothing else says where a component is, so that it hangs as it should however weakly it is bound.
        system = system + self.stiffness * (hangers.T @ hangers)
        # The system knows no translation; a weak hold makes it definite, and the centroid is set afterwards.
        self._factor = Cholesky(system + _HOLD * self.stiffness * sp.identity(self.count))

    def maps(self, vertices: np.ndarray) -> np.ndarray:
        """The linear map of every one-ring, never inside out.

        vertices: (..., V, 3).
        Returns (..., V, 3, 3).
        """
        planes, normals, area = self._planes(vertices)
        normal = np.sqrt(area)[..., None] * normals
        tangential = np.swapaxes(planes, -1, -2) @ np.swapaxes(self.tangents, -1, -2)
        return tangential + normal[..., :, None] * self.normals[:, None, :]

    def features(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices to features: rotation vectors (radians) and stretches minus one.

        vertices: (..., V, 3).
        Returns (..., V, 9).
        """
        # The map respects the splitting into plane and normal, so its polar decomposition is that of a 2x2 matrix,
        # whose square root has a closed form: sqrt(C) = (C + sqrt(det C)) / sqrt(tr C + 2 sqrt(det C)).
        planes, normals, area = self._planes(vertices)
        square = planes @ np.swapaxes(planes, -1, -2)
        trace = square[..., 0, 0] + square[..., 1, 1]
        root = (square + area[..., None, None] * np.eye(2)) / np.sqrt(trace + 2 * area)[..., None, None]
        inverse = np.stack([root[..., 1, 1], -root[..., 0, 1], -root[..., 0, 1], root[..., 0, 0]], axis=-1)
        inverse = inverse.reshape(root.shape) / area[..., None, None]
        turned = np.concatenate([inverse @ planes, normals[..., None, :]], axis=-2)
        frame = np.concatenate([self.tangents, self.normals[..., None]], axis=-1)
        rotations = np.swapaxes(turned, -1, -2) @ np.swapaxes(frame, -1, -2)
        stretch = self.tangents @ root @ np.swapaxes(self.tangents, -1, -2)
        stretch += (np.sqrt(area)[..., None, None] * self.normals[:, :, None]) * self.normals[:, None, :]
        symmetric = np.stack([stretch[..., a, b] - (a == b) for a, b in _STRETCH], axis=-1)
        return np.concatenate([rotation_vectors(rotations), symmetric], axis=-1)

    def _planes(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Images of the tangents (..., V, 2, 3), unit normals (..., V, 3), changes of area (..., V)."""
        planes = per_column(self.gradient, vertices).reshape(*vertices.shape[:-1], 2, 3)
        # A ring collapsed to a line or point has no plane; a trace of the template's gives it one.
        planes += _COLLAPSED * np.swapaxes(self.tangents, -1, -2)
        normals = np.cross(planes[..., 0, :], planes[..., 1, :])
        area = np.linalg.norm(normals, axis=-1)
        area = np.maximum(area, _COLLAPSED**2)
        return planes, normals / area[..., None], area

    def features_to_maps(self, features: np.ndarray) -> np.ndarray:
        """Features to linear maps. features: (..., V, 9). Returns (..., V, 3, 3)."""
        return rotation_matrices(features[..., :3]) @ _stretches(features)

    def planes_jacobian(self, features: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The tangent parts of the maps, and how they change along directions in feature space.

        features: (V, 9). directions: (D, V, 9).
        Returns (V, 2, 3) and (V, 2, 3, D).
        """
        rotations = rotation_matrices(features[:, :3])
        stretches = _stretches(features)
        planes = rotations @ (stretches @ self.tangents)
        # By each of the nine features first: they are few, directions are many.
        single = np.empty((self.count, 2, 3, directions.shape[-1]))
        # d exp(r) = [J_l(r) dr]_x exp(r), with the left Jacobian of the rotation group.
        turns = _left_jacobians(features[:, :3])
        single[..., :3] = np.swapaxes(np.cross(turns[:, :, None, :], planes[..., None], axis=1), 1, 2)
        for k, (a, b) in enumerate(_STRETCH, 3):
            change = np.zeros((3, 3))
            change[a, b] = change[b, a] = 1
            single[..., k] = np.swapaxes(rotations @ change @ self.tangents, 1, 2)
        along = single.reshape(self.count, 6, -1) @ np.moveaxis(directions, 0, -1)
        return np.swapaxes(planes, 1, 2), along.reshape(self.count, 2, 3, -1)

    def maps_to_vertices(self, maps: np.ndarray) -> np.ndarray:
        """The shape whose one-ring maps are nearest to the given ones, its centroid at the origin.

        maps: (..., V, 3, 3).
        Returns (..., V, 3).
        """
        planes = np.swapaxes(maps @ self.tangents, -1, -2).reshape(*maps.shape[:-3], 2 * self.count, 3)
        right = per_column(self.divergence, planes)
        vertices = self.solve(right)
        return vertices - vertices.mean(-2, keepdims=True)

    def vertices(self, features: np.ndarray) -> np.ndarray:
        """Features to vertices, the centroid at the origin. features: (..., V, 9). Returns (..., V, 3)."""
        return self.maps_to_vertices(self.features_to_maps(features))

    def vertices_like(self, features: np.ndarray, like: np.ndarray) -> np.ndarray:
        """Features (V, 9) to vertices (V, 3) whose components hang as in a shape like (V, 3), the centroid near 0."""
        return self.components.hang(self.vertices(features), like)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve the prefactored system for every column. right: (..., V, n). Returns the same shape."""
        columns = np.moveaxis(right, -2, 0)
        return np.moveaxis(self._factor.solve(columns.reshape(self.count, -1)).reshape(columns.shape), 0, -2)


def _weighted_edges(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ends i, j (E,) of all edges, in both directions, and their clipped cotangent weights (E,)."""
    # The cotangents of a triangle without area are NaN in libigl, or meaningless where rounding gives it a little.
    areas = igl.doublearea(vertices, faces)
    if areas.min() <= _LEAST_AREA * areas.mean():
        raise NumericsError("the template has triangles without area: deformation gradients need all of them")
    cotangents = igl.cotmatrix(vertices, faces).tocoo()
    off = cotangents.row != cotangents.col
    i = cotangents.row[off]
    weights = np.clip(cotangents.data[off], _MIN_WEIGHT, None)
    if not np.isfinite(weights).all() or len(np.unique(i)) < len(vertices):
        raise NumericsError("the template has vertices outside every triangle, or degenerate triangles")
    return i, cotangents.col[off], weights


def _stretches(features: np.ndarray) -> np.ndarray:
    stretch = np.empty((*features.shape[:-1], 3, 3))
    for k, (a, b) in enumerate(_STRETCH):
        stretch[..., a, b] = stretch[..., b, a] = features[..., 3 + k] + (a == b)
    return stretch


def _left_jacobians(vectors: np.ndarray) -> np.ndarray:
    """Left Jacobians (V, 3, 3) of the rotation group at rotation vectors (V, 3)."""
    angles = np.linalg.norm(vectors, axis=-1)[:, None, None]
    small = angles < _SMALL_ANGLE
    safe = np.where(small, 1.0, angles)
    first = np.where(small, 0.5 - angles**2 / 24, (1 - np.cos(safe)) / safe**2)
    second = np.where(small, 1 / 6 - angles**2 / 120, (safe - np.sin(safe)) / safe**3)
    cross = np.zeros((len(vectors), 3, 3))
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        cross[:, b, c] = -vectors[:, a]
        cross[:, c, b] = vectors[:, a]
    return np.eye(3) + first * cross + second * cross @ cross
