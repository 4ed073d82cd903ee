"""The expressions that rigs are made of: those of the open head, or anybody's own."""

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import cached_property

import igl
import numpy as np
import scipy.sparse as sp

from caricli.errors import InputError
from caricli.geometry.deformation.deformation_transfer import triangle_frames
from caricli.geometry.repair.contact_pairs import closes, closing_pairs, touching_pairs
from caricli.geometry.repair.flat_triangles import flat_triangles
from caricli.geometry.smooth_step import smooth_step
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.io.kept import kept_arrays
from caricli.structures import Mesh
from caricli.structures.arkit import Expressions, alone, arkit_name, start_delta, start_of
from caricli.template.annotation import Annotation
from caricli.template.template import Template

_FAINTEST = 1e-12
"""Length below which a direction is left as it is: only a direction of zero length is so short."""

_AGREES = 0.5
"""Cosine: a normal that is farther from the usual one is that of a crumpled lip."""


@dataclass(frozen=True)
class ContactSettings:
    """When vertices of an expression touch, move or come together.

    reach: share of the head's height; surfaces that touch are no farther apart. Lids that a blink closes and lips at
    rest are within it.
    still: share of the head's height; what moves no farther does not move, but for rounding.
    spacing: share of reach; no two pairs start and end as near to each other, so that a finer mesh has no more of them.
    most: pairs; the dense system of the contacts grows with their square.
    coarser: factor of the spacing while there are more pairs than ``most``.
    faint: share of an expression's farthest displacement; below it triangles say less than the displacements.
    fade: edges over which a correction fades out around what moves.
    """

    reach: float = 0.009
    still: float = 1e-6
    spacing: float = 0.3
    most: int = 420
    coarser: float = 1.2
    faint: float = 0.1
    fade: int = 4


@dataclass(frozen=True, eq=False)
class Motion:
    """One expression, from the neutral face (start included).

    triangles: (m,) that change.
    maps: (m, 3, 3) of them.
    moved: (V, 3) displacements, metres.
    trust: (V,) from 0 where nothing moves to 1.
    near: (V,) 1 where something moves, falling to 0 around it.
    closed: (P,) bool, pairs that come together.
    offsets: (P, 3) between the vertices of pairs, metres.
    gaps: (P,) along their normals in the neutral face, metres.
    """

    triangles: np.ndarray
    maps: np.ndarray
    moved: np.ndarray
    trust: np.ndarray
    near: np.ndarray
    closed: np.ndarray
    offsets: np.ndarray
    gaps: np.ndarray


@dataclass(frozen=True, eq=False)
class ExpressionTemplates:
    """A neutral face and its expressions.

    names: (K,).
    mesh: Mesh of the neutral face, metres; a Template where lids, lips and eyes are known by name.
    deltas: (K, V, 3) metres, of each expression alone.
    settings: ContactSettings.
    weights: (K,) of each, by name the weights of the actions that it is made of; or None, where each is an action.
    """

    names: tuple[str, ...]
    mesh: Mesh
    deltas: np.ndarray
    settings: ContactSettings = ContactSettings()
    weights: tuple[Mapping[str, float], ...] | None = None

    @property
    def neutral(self) -> np.ndarray:
        """(V, 3) vertices of the neutral face."""
        return self.mesh.vertices

    @property
    def faces(self) -> np.ndarray:
        """(F, 3) triangles of the mesh."""
        return self.mesh.faces

    @property
    def annotation(self) -> Annotation | None:
        """What is known by name on the mesh."""
        return self.mesh.annotation if isinstance(self.mesh, Template) else None

    @property
    def reach(self) -> float:
        """How near touching surfaces are, in metres."""
        return self.settings.reach * self.mesh.height

    @property
    def expressions(self) -> Expressions:
        """Of what actions they are made."""
        return alone(self.names) if self.weights is None else dict(zip(self.names, self.weights, strict=True))

    @cached_property
    def still(self) -> np.ndarray:
        """(V,) bool: vertices that no expression moves."""
        return (np.abs(self.deltas) <= self.settings.still * self.mesh.height).all((0, 2))

    def require_topology(self, mesh: Mesh) -> None:
        """Raise InputError for a mesh of another topology."""
        if mesh.topology_id != self.mesh.topology_id:
            expected = f"{len(self.neutral)} vertices, {len(self.faces)} triangles"
            hint = ", or of a whole head its skin, as --parts skin writes it" if mesh.begins_with(self.mesh) else ""
            cut = mesh.cut_hint(self.mesh)
            hint = hint if cut is None else f", or {cut}"
            raise InputError(
                f"expected the topology of the templates ({expected}), found another ({len(mesh.vertices)} vertices, "
                f"{len(mesh.faces)}); give templates of its own mesh (--templates){hint}"
            )

    def start(self, k: int) -> np.ndarray:
        """(V, 3) what expression k starts from."""
        return self.neutral + start_delta(self.names, self.deltas, k)

    @cached_property
    def order(self) -> list[int]:
        """Numbers of the expressions, those that start from others last."""
        return sorted(range(len(self.names)), key=lambda k: bool(start_of(self.names[k])))

    @cached_property
    def pairs(self) -> np.ndarray:
        """(P, 2) vertices that touch, in the neutral face or in any expression."""
        return self._contacts["pairs"]

    @cached_property
    def _contacts(self) -> Mapping[str, np.ndarray]:
        """``pairs``, and (V,) bool, which vertices touch something in the neutral face."""
        given = ("\n".join(self.names), self.neutral, self.faces, self.deltas, *astuple(self.settings))
        return kept_arrays("contacts", given, self._find_contacts)

    def _find_contacts(self) -> dict[str, np.ndarray]:
        candidates = [touching_pairs(self.neutral, self.faces, self.reach)]
        touching = np.zeros(len(self.neutral), dtype=bool)
        touching[candidates[0]] = True
        for k, delta in enumerate(self.deltas):
            closing = closing_pairs(self.start(k), self.start(k) + delta, self.faces, self.reach)
            candidates.append(closing[~self._slides(closing, k, touching)])
        pairs = np.unique(np.concatenate(candidates), axis=0)
        spacing = self.settings.spacing * self.reach
        while len(kept := thin_pairs(pairs, self.neutral, spacing)) > self.settings.most:
            spacing *= self.settings.coarser
        return {"pairs": kept, "touching": touching}

    @cached_property
    def normals(self) -> np.ndarray:
        """(P, 3) unit directions of the pairs, from the second to the first vertex."""
        return contact_normals(self.mesh, self.pairs, self.reach)

    @cached_property
    def motions(self) -> list[Motion | None]:
        """For every expression what is needed to do it elsewhere, or None where nothing moves."""
        return [self._motion(k) for k in range(len(self.names))]

    def fade(self, seeds: np.ndarray) -> np.ndarray:
        """(V,) 1 at the seeds (V,) bool, falling to 0 over a few edges around them."""
        near = seeds.astype(float)
        rings = self.settings.fade
        for ring in range(rings):
            near = np.maximum(near, (1 - (ring + 1) / (rings + 1)) * (self._adjacency @ near > 0))
        return near

    def _slides(self, pairs: np.ndarray, k: int, touching: np.ndarray) -> np.ndarray:
        """(P,) whether both vertices of pairs touch something before expression k: then they only meet by sliding.

        touching: (V,) bool, what does in the neutral face.
        """
        if start_of(self.names[k]) in [arkit_name(name) for name in self.names]:
            return np.zeros(len(pairs), dtype=bool)
        return touching[pairs].all(axis=1)

    @cached_property
    def _adjacency(self) -> sp.csr_matrix:
        return vertex_neighbours(self.faces, len(self.neutral))[0]

    @cached_property
    def _unframed(self) -> np.ndarray:
        """(F, 3, 3) inverses of the triangles' frames in the neutral face."""
        return np.linalg.inv(triangle_frames(self.neutral, self.faces))

    def _motion(self, k: int) -> Motion | None:
        start = self.start(k)
        shape = start + self.deltas[k]
        still = (np.abs(shape - self.neutral) <= self.settings.still * self.mesh.height).all(1)
        if still.all():
            return None
        shape = np.where(still[:, None], self.neutral, shape)
        triangles = np.flatnonzero(~still[self.faces].all(1))
        before = start[self.pairs[:, 0]] - start[self.pairs[:, 1]]
        after = shape[self.pairs[:, 0]] - shape[self.pairs[:, 1]]
        closed = closes(np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1), self.reach)
        moved = shape - self.neutral
        size = np.linalg.norm(moved, axis=1)
        return Motion(
            triangles=triangles,
            maps=triangle_frames(shape, self.faces[triangles]) @ self._unframed[triangles],
            moved=moved,
            trust=smooth_step(size, 0, self.settings.faint * size.max()),
            near=self.fade(size > 0),
            closed=closed & ~self._slides(self.pairs, k, self._contacts["touching"]),
            offsets=after,
            gaps=(after * self.normals).sum(1),
        )


def combine_templates(templates: ExpressionTemplates, expressions: dict[str, dict[str, float]]) -> ExpressionTemplates:
    """ExpressionTemplates of combinations. expressions: names to names of templates and their weights."""
    actions = dict(zip(templates.names, templates.deltas, strict=True))
    none = np.zeros_like(templates.neutral)
    deltas = [sum((w * actions[name] for name, w in weights.items()), none) for weights in expressions.values()]
    names, weights = zip(*expressions.items(), strict=True)
    return ExpressionTemplates(names, templates.mesh, np.array(deltas), templates.settings, weights)


def check_templates(names: Sequence[str], mesh: Mesh, shapes: np.ndarray) -> ExpressionTemplates:
    """ExpressionTemplates of shapes (K, V, 3), or InputError where the mesh is none to transfer from."""
    faces = mesh.faces
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    shared = np.unique(edges, axis=0, return_counts=True)[1].max()
    if shared > 2:
        raise InputError(f"expected at most two triangles on every edge, found {shared} on one")
    unused = len(mesh.vertices) - len(np.unique(faces))
    if unused:
        raise InputError(f"expected every vertex in a triangle, found {unused} without")
    flat = flat_triangles(mesh.vertices, faces)
    if flat.any():
        raise InputError(f"expected triangles with an area, found {flat.sum()} without")
    templates = ExpressionTemplates(tuple(names), mesh, shapes - mesh.vertices)
    if templates.still.all():
        raise InputError(f"expected expressions that move something, found {len(names)} that do not")
    return templates


def thin_pairs(pairs: np.ndarray, vertices: np.ndarray, spacing: float) -> np.ndarray:
    """Pairs of which no two start and end as near to each other, so that finer meshes do not have more of them.

    Those nearest to touching are kept, whatever the order of vertices and wherever the mesh stands.
    pairs: (P, 2). vertices: (V, 3). spacing: in their unit.
    """
    # Imported here: it takes a while, and what comes of it is mostly kept.
    from scipy.spatial import KDTree

    ends = vertices[pairs]
    middles = ends.mean(1)
    tree = KDTree(middles)
    kept = np.zeros(len(pairs), dtype=bool)
    left = np.ones(len(pairs), dtype=bool)
    for k in np.argsort(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1), kind="stable"):
        if left[k]:
            near = np.array(tree.query_ball_point(middles[k], spacing))
            ways = [np.linalg.norm(ends[near] - own, axis=2).max(1) for own in (ends[k], ends[k, ::-1])]
            left[near[np.minimum(*ways) < spacing]] = False
            kept[k] = True
    return pairs[kept]


def contact_normals(mesh: Mesh, pairs: np.ndarray, reach: float, usual: np.ndarray | None = None) -> np.ndarray:
    """(P, 3) unit directions from the second to the first vertex of pairs, by their normals where they touch.

    pairs: (P, 2). reach: metres. usual: (P, 3) unit directions, taken where those of crumpled lips point elsewhere; or
    None.
    """
    vertices = mesh.vertices
    around = igl.per_vertex_normals(vertices, mesh.faces)
    offsets = vertices[pairs[:, 0]] - vertices[pairs[:, 1]]
    touching = np.linalg.norm(offsets, axis=1, keepdims=True) < reach
    directions = np.where(touching, around[pairs[:, 1]] - around[pairs[:, 0]], offsets)
    directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), _FAINTEST)
    if usual is None:
        return directions
    return np.where((directions * usual).sum(1, keepdims=True) > _AGREES, directions, usual)
