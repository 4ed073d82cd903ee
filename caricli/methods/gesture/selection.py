"""What of a face is selected: handles by brush, a region by a closed stroke."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from caricli.errors import InputError
from caricli.geometry.lines.line_distances import line_distances
from caricli.methods.gesture.settings import GestureSettings
from caricli.methods.gesture.sight import Sight
from caricli.structures import Camera, Face
from caricli.structures.checks import coordinate_problem, refuse
from caricli.template.template import Template

_LEAST_REGION = 4
"""Vertices that a region has at least."""


def _nothing() -> np.ndarray:
    return np.zeros(0, np.int64)


@dataclass(frozen=True, eq=False)
class Selection:
    """Vertices by what they are for.

    handles: (K,) ids that a line moves. region: (R,) ids outside of which nothing moves, none where all may. skin: (S,)
    those of the region that were seen when it was chosen; pockets behind them go along.
    """

    handles: np.ndarray = field(default_factory=_nothing)
    region: np.ndarray = field(default_factory=_nothing)
    skin: np.ndarray = field(default_factory=_nothing)

    def mirrored(self, template: Template) -> "Selection":
        """What is on the other side of the face. Raises InputError where the template has no mirror map."""
        mirror = mirror_map(template)
        return Selection(*(np.sort(mirror[ids]) for ids in (self.handles, self.region, self.skin)))

    def with_other(self, other: "Selection") -> "Selection":
        """Both together."""
        pairs = ((self.handles, other.handles), (self.region, other.region), (self.skin, other.skin))
        return Selection(*(np.union1d(a, b) for a, b in pairs))

    def as_json(self) -> Mapping[str, int]:
        """How many there are, for reports."""
        return {"handles": len(self.handles), "region": len(self.region)}


def mirror_map(template: Template) -> np.ndarray:
    """(V,) the vertex on the other side of every vertex. Raises InputError where none is known."""
    if template.annotation.mirror is None:
        raise InputError("expected a head with a mirror map for what is symmetric, found none")
    return template.annotation.mirror


def mark_handles(
    face: Face, camera: Camera, stroke: np.ndarray, radius: float, selection: Selection, erase: bool = False
) -> Selection:
    """Brush vertices into the handles of a selection, or out of them.

    face: Face. camera: Camera of the view. stroke: (N, 2) pixels, one point for a dab. radius: of the brush, pixels.
    Returns a Selection. Raises InputError where the brush touches nothing that is seen.
    """
    sight = Sight(face.mesh, camera)
    touched = sight.seen & (line_distances(sight.pixels, [checked_stroke(stroke, 1)]) <= radius)
    if not touched.any():
        raise InputError("expected a stroke over the face, found none of it below the brush")
    ids = np.flatnonzero(touched)
    change = np.setdiff1d if erase else np.union1d
    return replace(selection, handles=change(selection.handles, ids))


def select_region(face: Face, camera: Camera, stroke: np.ndarray, selection: Selection) -> Selection:
    """The region of interest within a closed stroke: what is seen there, and what of the surface belongs to it.

    What is hidden within the stroke belongs to it as far as ``GestureSettings.behind`` along the surface, and so does
    every pocket that only the region leads to: nostrils, and the mouth where all of it is within.

    face: Face. camera: Camera of the view. stroke: (N, 2) pixels; its end is joined to its beginning.
    Returns the Selection with this region in the place of its own. Raises InputError where nothing is within.
    """
    sight = Sight(face.mesh, camera)
    within = inside_ring(sight.pixels, checked_stroke(stroke, 3))
    skin = within & sight.seen
    if skin.sum() < _LEAST_REGION:
        raise InputError("expected a closed stroke around a part of the face, found none of it within")
    size = float(np.linalg.norm(np.ptp(face.vertices[skin], axis=0)))
    ways = surface_ways(face.vertices, face.faces, within)
    near = dijkstra(ways, indices=np.flatnonzero(skin), limit=GestureSettings.behind * size, min_only=True)
    region = with_pockets(face.faces, np.isfinite(near) & within)
    return replace(selection, region=np.flatnonzero(region), skin=np.flatnonzero(skin))


def around_handles(face: Face, handles: np.ndarray, height: float, settings: GestureSettings) -> np.ndarray:
    """(R,) ids of a region around handles (K,), where none was chosen. height: of the head, metres."""
    ways = surface_ways(face.vertices, face.faces, np.ones(len(face.vertices), bool))
    near = dijkstra(ways, indices=handles, limit=settings.reach * height, min_only=True)
    return np.flatnonzero(with_pockets(face.faces, np.isfinite(near)))


def surface_ways(vertices: np.ndarray, faces: np.ndarray, within: np.ndarray) -> sp.csr_matrix:
    """(V, V) lengths of the edges between vertices that are ``within`` (V,) bool."""
    pairs = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    pairs = np.unique(np.sort(pairs[within[pairs].all(1)], axis=1), axis=0)
    lengths = np.linalg.norm(vertices[pairs[:, 0]] - vertices[pairs[:, 1]], axis=1)
    # An edge without length would be none.
    lengths = np.maximum(lengths, 1e-12)
    count = len(vertices)
    return sp.csr_matrix((np.tile(lengths, 2), (pairs.T.ravel(), pairs[:, ::-1].T.ravel())), (count, count))


def with_pockets(faces: np.ndarray, region: np.ndarray) -> np.ndarray:
    """(V,) bool: a region with what is cut off by it from the largest rest of the surface. region: (V,) bool."""
    if region[faces].any(1).all():
        return region
    count = len(region)
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    rest = edges[~region[edges].any(1)]
    links = sp.csr_matrix((np.ones(len(rest)), rest.T), (count, count))
    labels = sp.csgraph.connected_components(links, directed=False)[1]
    main = np.bincount(labels[~region]).argmax()
    # Parts that no edge leads to from the region, such as another component of the mesh, stay where they are.
    touching = np.zeros(count, bool)
    crossing = edges[region[edges].sum(1) == 1]
    touching[labels[crossing[~region[crossing]]]] = True
    return region | (touching[labels] & (labels != main))


def checked_stroke(stroke: np.ndarray, least: int) -> np.ndarray:
    """A stroke (N, 2) of so many points at least. Raises InputError for anything else."""
    points = np.asarray(stroke, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < least:
        raise InputError(f"expected a stroke of (N,2) pixels with N of {least} at least, found {points.shape}")
    refuse(coordinate_problem("stroke", points))
    return points


def inside_ring(points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """(V,) bool: which points (V, 2) a closed line (N, 2) goes around, by its winding number."""
    turns = np.zeros(len(points), int)
    for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        side = (end[0] - start[0]) * (points[:, 1] - start[1]) - (points[:, 0] - start[0]) * (end[1] - start[1])
        turns += (start[1] <= points[:, 1]) & (end[1] > points[:, 1]) & (side > 0)
        turns -= (start[1] > points[:, 1]) & (end[1] <= points[:, 1]) & (side < 0)
    return turns != 0
