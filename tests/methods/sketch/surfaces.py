"""Surfaces whose curvature is known in closed form, with meshes of them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from caricli.structures import Mesh


@dataclass(frozen=True, eq=False)
class Surface:
    """The zeros of a function that is positive outside.

    value, gradient, hessian: of points (N, 3), giving (N,), (N, 3) and (N, 3, 3). mesh: of it.
    """

    value: Callable[[np.ndarray], np.ndarray]
    gradient: Callable[[np.ndarray], np.ndarray]
    hessian: Callable[[np.ndarray], np.ndarray]
    mesh: Mesh

    def onto(self, points: np.ndarray) -> np.ndarray:
        """Nearby points (N, 3) of the surface, by Newton's steps."""
        for _ in range(20):
            slope = self.gradient(points)
            points = points - (self.value(points) / (slope**2).sum(1))[:, None] * slope
        return points

    def normals(self, points: np.ndarray) -> np.ndarray:
        """(N, 3) unit, outwards."""
        slope = self.gradient(points)
        return slope / np.linalg.norm(slope, axis=1, keepdims=True)

    def radial(self, points: np.ndarray, view: np.ndarray) -> np.ndarray:
        """(N,) curvature in the direction of the view's projection. view: (3,) to the viewer."""
        along = self.along(points, view)
        return np.einsum("na,nab,nb->n", along, self.hessian(points), along) / np.linalg.norm(
            self.gradient(points), axis=1
        )

    def along(self, points: np.ndarray, view: np.ndarray) -> np.ndarray:
        """(N, 3) unit, the view's projection onto the surface."""
        normals = self.normals(points)
        along = view - (normals @ view)[:, None] * normals
        return along / np.linalg.norm(along, axis=1, keepdims=True)

    def derivative(self, points: np.ndarray, view: np.ndarray, way: np.ndarray, step: float = 1e-4) -> np.ndarray:
        """(N,) change of the radial curvature along unit tangents way (N, 3), by differences."""
        ahead, behind = (self.radial(self.onto(points + sign * step * way), view) for sign in (1, -1))
        return (ahead - behind) / (2 * step)

    def is_seen(self, points: np.ndarray, view: np.ndarray, lift: float, reach: float = 4.0) -> np.ndarray:
        """(N,) whether a step along the normal and then to the viewer nothing is in the way, place by place."""
        start = points + lift * self.normals(points)
        steps = np.linspace(0, reach, 1500)
        return np.array([(self.value(point + steps[:, None] * view) > 0).all() for point in start])


def _grid(u: np.ndarray, v: np.ndarray, wrap: tuple[bool, bool]) -> np.ndarray:
    """Quads over a grid of len(u) x len(v) points, joined at the ends where it wraps."""
    rows = np.arange(len(u) if wrap[0] else len(u) - 1)
    columns = np.arange(len(v) if wrap[1] else len(v) - 1)
    i, j = (axis.ravel() for axis in np.meshgrid(rows, columns, indexing="ij"))
    after = (i + 1) % len(u)
    right = (j + 1) % len(v)
    return np.stack([i * len(v) + j, after * len(v) + j, after * len(v) + right, i * len(v) + right], 1).astype(
        np.int32
    )


def torus(ring: float = 1.0, tube: float = 0.4, counts: tuple[int, int] = (160, 80)) -> Surface:
    """Around the y axis."""
    u = np.linspace(0, 2 * np.pi, counts[0], endpoint=False)
    v = np.linspace(0, 2 * np.pi, counts[1], endpoint=False)
    a, b = (axis.ravel() for axis in np.meshgrid(u, v, indexing="ij"))
    radius = ring + tube * np.cos(b)
    points = np.stack([radius * np.sin(a), tube * np.sin(b), radius * np.cos(a)], axis=1)

    def value(p: np.ndarray) -> np.ndarray:
        return (np.hypot(p[:, 0], p[:, 2]) - ring) ** 2 + p[:, 1] ** 2 - tube**2

    def gradient(p: np.ndarray) -> np.ndarray:
        far = np.hypot(p[:, 0], p[:, 2])
        scale = 2 * (far - ring) / far
        return np.stack([scale * p[:, 0], 2 * p[:, 1], scale * p[:, 2]], axis=1)

    def hessian(p: np.ndarray) -> np.ndarray:
        far = np.hypot(p[:, 0], p[:, 2])
        flat = p * [1, 0, 1]
        outer = flat[:, :, None] * flat[:, None, :] * (2 * ring / far**3)[:, None, None]
        return outer + np.stack([2 - 2 * ring / far, np.full(len(p), 2.0), 2 - 2 * ring / far], 1)[:, None] * np.eye(3)

    return Surface(value, gradient, hessian, Mesh(points, _grid(u, v, (True, True))))


def ellipsoid(axes: tuple[float, float, float] = (0.8, 1.0, 0.6), counts: tuple[int, int] = (120, 60)) -> Surface:
    """Without its poles."""
    u = np.linspace(0, 2 * np.pi, counts[0], endpoint=False)
    v = np.linspace(-1.5, 1.5, counts[1])
    a, b = (axis.ravel() for axis in np.meshgrid(u, v, indexing="ij"))
    points = np.stack([np.cos(b) * np.sin(a), np.sin(b), np.cos(b) * np.cos(a)], axis=1) * axes
    weights = 2 / np.square(axes)
    return Surface(
        lambda p: (p**2 * weights / 2).sum(1) - 1,
        lambda p: p * weights,
        lambda p: np.tile(np.diag(weights), (len(p), 1, 1)),
        Mesh(points, _grid(u, v, (True, False))),
    )


def bump(height: float = 0.5, width: float = 0.3, count: int = 110) -> Surface:
    """A bell on a plane that faces +z."""
    u = np.linspace(-1, 1, count)
    x, y = (axis.ravel() for axis in np.meshgrid(u, u, indexing="ij"))

    def bell(p: np.ndarray) -> np.ndarray:
        return height * np.exp(-(p[:, 0] ** 2 + p[:, 1] ** 2) / (2 * width**2))

    def gradient(p: np.ndarray) -> np.ndarray:
        slope = bell(p)[:, None] * p[:, :2] / width**2
        return np.column_stack([slope, np.ones(len(p))])

    def hessian(p: np.ndarray) -> np.ndarray:
        flat = np.zeros((len(p), 3, 3))
        outer = p[:, :2, None] * p[:, None, :2] / width**4
        flat[:, :2, :2] = bell(p)[:, None, None] * (np.eye(2) / width**2 - outer)
        return flat

    points = np.stack([x, y, bell(np.stack([x, y], 1))], axis=1)
    return Surface(lambda p: p[:, 2] - bell(p), gradient, hessian, Mesh(points, _grid(u, u, (False, False))))
