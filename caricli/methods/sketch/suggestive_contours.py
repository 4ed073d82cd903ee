"""Wrinkle lines: contours, and what would be contours from nearby (DeCarlo et al. 2003)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.geometry.curvature_tensors import curvature_tensors
from caricli.geometry.lines.zero_lines import MeshLine, zero_lines
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.seen_points import seen_points
from caricli.structures.camera import Camera
from caricli.structures.mesh import Mesh


@dataclass(frozen=True)
class ContourSettings:
    """Which lines are drawn. Lengths are of the mesh's height, so that no size of a head matters.

    levels: how often the surface is split and smoothed (Loop) before it is looked at. smoothing: rounds in which the
    curvature of a vertex of the split surface becomes the mean of its own and its neighbours'. steep, keep: least
    derivative of the radial curvature along the view, in 1/height^2, that begins a line, and that continues it. facing:
    degrees that the surface turns away from the viewer at least, for straight on the direction of the view has no
    meaning. shortest: length of a line. lift: how far points are taken off the surface before what hides them is
    looked for.
    """

    levels: int = 1
    smoothing: int = 4
    steep: float = 220.0
    keep: float = 80.0
    facing: float = 14.0
    shortest: float = 0.035
    lift: float = 0.006


@dataclass(frozen=True, eq=False)
class ContourLine:
    """A line on a surface.

    points: (N, 3) metres. strength: mean derivative of the radial curvature along the view, 1/height^2; infinite for a
    contour, where the surface turns away.
    """

    points: np.ndarray
    strength: float


class ContourFinder:
    """Finds the lines of meshes of one topology; what their shape does not change is prepared once."""

    def __init__(self, mesh: Mesh, region: np.ndarray, settings: ContourSettings | None = None) -> None:
        """mesh: Mesh. region: (V,) bool, vertices between which lines are drawn. settings: ContourSettings."""
        import igl

        self.settings = settings or ContourSettings()
        self.faces = mesh.faces
        around = _grown(region, mesh.faces, 2)
        used = mesh.faces[around[mesh.faces].all(1)]
        ids, faces = np.unique(used, return_inverse=True)
        faces = faces.reshape(-1, 3)
        weights = sp.csr_matrix((np.ones(len(ids)), (np.arange(len(ids)), ids)), (len(ids), len(region)))
        for _ in range(self.settings.levels if len(faces) else 0):
            step, faces = igl.loop_matrix(faces.astype(np.int64), weights.shape[0])
            weights = sp.csr_matrix(step) @ weights
        self.weights = weights.tocsr()
        inside = self.weights @ region.astype(float) > 0.999
        self.fine = faces.astype(np.int32)
        self.drawn = self.fine[inside[self.fine].all(1)]
        self.average = _average(self.fine, weights.shape[0])

    def lines(self, vertices: np.ndarray, camera: Camera) -> list[ContourLine]:
        """The visible lines of a shape.

        vertices: (V, 3) metres. camera: Camera. Returns ContourLines, the strongest first.
        """
        if not len(self.drawn):
            return []
        height = float(np.ptp(vertices[:, 1]))
        fine = self.weights @ vertices
        surface = _Surface.of(fine, self.fine, -camera.rotation[2], self.average, self.settings.smoothing)
        turned = np.cos(np.radians(self.settings.facing))
        candidates: list[tuple[MeshLine, float]] = []
        for line in zero_lines(surface.radial, self.drawn):
            steep = line.of(surface.derivative) * height**2
            facing = line.of(surface.facing)
            good = (steep > self.settings.keep) & (facing > 0) & (facing < turned)
            for start, end in runs(good):
                if steep[start:end].max() > self.settings.steep:
                    candidates.append((line.part(start, end), float(steep[start:end].mean())))
        candidates += [(line, np.inf) for line in zero_lines(surface.facing, self.drawn)]
        lifted = [line.of(fine) + self.settings.lift * height * line.of(surface.normals) for line, _ in candidates]
        lines = []
        for (line, strength), seen in zip(candidates, self._seen(lifted, vertices, camera), strict=True):
            points = line.of(fine)
            lines += [ContourLine(points[start:end], strength) for start, end in runs(seen)]
        shortest = self.settings.shortest * height
        long = [line for line in lines if np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum() > shortest]
        return sorted(long, key=lambda line: -line.strength)

    def _seen(self, lines: list[np.ndarray], vertices: np.ndarray, camera: Camera) -> list[np.ndarray]:
        """Which points of lines (N, 3) nothing hides."""
        if not lines:
            return []
        points = np.concatenate(lines)
        seen = seen_points(camera.place(points), camera.place(vertices), self.faces)
        return np.split(seen, np.cumsum([len(line) for line in lines])[:-1])


@dataclass(frozen=True, eq=False)
class _Surface:
    """What lines are found by, at every vertex: normals, the cosine between normal and view, the radial curvature, and
    its derivative along the view."""

    normals: np.ndarray
    facing: np.ndarray
    radial: np.ndarray
    derivative: np.ndarray

    @staticmethod
    def of(
        vertices: np.ndarray, faces: np.ndarray, view: np.ndarray, average: sp.csr_matrix, rounds: int
    ) -> "_Surface":
        """view: (3,) unit, to the viewer. average: (V, V) sparse. rounds: of smoothing."""
        normals = smooth_normals(vertices, faces)
        tensors = curvature_tensors(vertices, faces, normals).reshape(-1, 9)
        for _ in range(rounds):
            tensors = average @ tensors
        facing = normals @ view
        along = view - facing[:, None] * normals
        squared = (along**2).sum(1)
        radial = np.einsum("va,vab,vb->v", along, tensors.reshape(-1, 3, 3), along)
        radial /= np.maximum(squared, 1e-12)
        slope = _gradients(vertices, faces, radial)
        derivative = (slope * along).sum(1) / np.sqrt(np.maximum(squared, 1e-12))
        return _Surface(normals, facing, radial, derivative)


def _gradients(vertices: np.ndarray, faces: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(V, 3) gradients of a function that is linear in every triangle, the mean of a vertex's triangles by area."""
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    squared = (normal**2).sum(1)
    total = np.zeros((len(faces), 3))
    for k in range(3):
        opposite = corners[:, (k + 2) % 3] - corners[:, (k + 1) % 3]
        total += values[faces[:, k], None] * np.cross(normal, opposite)
    area = np.sqrt(squared)
    # Divided by the squared length of the normal it is the gradient; once only, it is weighted by area.
    total /= np.where(area > 0, area, 1)[:, None]
    sums = np.stack([np.bincount(faces.ravel(), np.repeat(total[:, a], 3), len(vertices)) for a in range(3)], axis=1)
    weight = np.bincount(faces.ravel(), np.repeat(area, 3), len(vertices))
    return sums / np.where(weight > 0, weight, 1)[:, None]


def _average(faces: np.ndarray, count: int) -> sp.csr_matrix:
    """(V, V) sparse: the mean of a vertex and its neighbours."""
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    both = np.concatenate([pairs, pairs[:, ::-1], np.repeat(np.arange(count)[:, None], 2, axis=1)])
    table = sp.csr_matrix((np.ones(len(both)), both.T), (count, count))
    table.data[:] = 1
    return sp.diags(1 / np.asarray(table.sum(1)).ravel()) @ table


def _grown(region: np.ndarray, faces: np.ndarray, rings: int) -> np.ndarray:
    """(V,) bool: a region and the rings of vertices around it."""
    grown = region.copy()
    for _ in range(rings):
        grown[faces[grown[faces].any(1)]] = True
    return grown


def runs(good: np.ndarray) -> list[tuple[int, int]]:
    """Starts and ends of the longest stretches of at least two points that are good."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 1]
