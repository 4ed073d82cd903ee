"""The expressions that rigs are made of: those of the open head, mended, or anybody's own."""

from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np

from caricli.errors import InputError
from caricli.geometry.contact_pairs import closes, closing_pairs, touching_pairs
from caricli.geometry.contact_solver import ContactSolver
from caricli.geometry.deformation_transfer import DeformationTransfer, triangle_maps
from caricli.geometry.triangle_normals import triangle_normals
from caricli.geometry.vertex_neighbours import vertex_neighbours

STARTS = {"mouthClose": "jawOpen"}
"""Expressions that only mean something on top of others: ARKit's mouthClose closes the lips while the jaw is open."""

REACH = 0.009
STRENGTH = {"eyeBlinkLeft": 0.8, "eyeBlinkRight": 0.8}
_STILL = 1e-6
_TOUCH = 2e-4
_AGREES, _FLAT, _SPACING, _NOTICED = 0.5, 1e-10, 0.5, 5e-5
_MOST = 420
_FAINT, _FADE = 0.1, 4


@dataclass(frozen=True, eq=False)
class ExpressionTemplates:
    """A neutral face and its expressions.

    names (K,); neutral (V, 3) metres; faces (F, 3); deltas (K, V, 3), of each expression alone.
    """

    names: tuple
    neutral: np.ndarray
    faces: np.ndarray
    deltas: np.ndarray

    @property
    def reach(self):
        """How near touching surfaces are, in metres."""
        return REACH * float(np.ptp(self.neutral[:, 1]))

    @cached_property
    def still(self):
        """(V,) bool: vertices that no expression moves."""
        return (np.abs(self.deltas) <= _STILL * np.ptp(self.neutral[:, 1])).all((0, 2))

    def start(self, k):
        """(V, 3) what expression k starts from."""
        return self.neutral + start_delta(self.names, self.deltas, k)

    @cached_property
    def pairs(self):
        """(P, 2) vertices that touch, in the neutral face or in any expression."""
        found = [touching_pairs(self.neutral, self.faces, self.reach)]
        for k, delta in enumerate(self.deltas):
            pairs = closing_pairs(self.start(k), self.start(k) + delta, self.faces, self.reach)
            found.append(pairs[~self._slides(pairs, k)])
        pairs, spacing = np.unique(np.concatenate(found), axis=0), _SPACING * self.reach
        while len(kept := thinned(pairs, self.neutral, spacing)) > _MOST:
            spacing *= 1.2
        return kept

    def _slides(self, pairs, k):
        """(P,) whether both vertices of pairs touch something before expression k: then they only meet by sliding."""
        if STARTS.get(self.names[k]) in self.names:
            return np.zeros(len(pairs), dtype=bool)
        return self._touching[pairs].all(axis=1)

    @cached_property
    def _touching(self):
        touching = np.zeros(len(self.neutral), dtype=bool)
        touching[touching_pairs(self.neutral, self.faces, self.reach)] = True
        return touching

    @cached_property
    def normals(self):
        """(P, 3) unit directions of the pairs, from the second to the first vertex."""
        return contact_normals(self.neutral, self.faces, self.pairs, self.reach)

    @cached_property
    def motions(self):
        """For every expression what is needed to do it elsewhere, a Motion, or None where nothing moves."""
        return [self._motion(k, self.normals) for k in range(len(self.names))]

    def _motion(self, k, normals):
        start, shape = self.start(k), self.start(k) + self.deltas[k]
        still = (np.abs(shape - self.neutral) <= _STILL * np.ptp(self.neutral[:, 1])).all(1)
        if still.all():
            return None
        shape = np.where(still[:, None], self.neutral, shape)
        triangles = np.flatnonzero(~still[self.faces].all(1))
        maps = triangle_maps(self.neutral, shape, self.faces[triangles])
        then, now = (v[self.pairs[:, 0]] - v[self.pairs[:, 1]] for v in (start, shape))
        closed = closes(*(np.linalg.norm(offsets, axis=1) for offsets in (then, now)), self.reach)
        closed &= ~self._slides(self.pairs, k)
        moved = shape - self.neutral
        size = np.linalg.norm(moved, axis=1)
        trust = np.clip(size / (_FAINT * size.max()), 0, 1)
        near = _fading(size > 0, self._adjacency)
        return Motion(triangles, maps, moved, trust**2 * (3 - 2 * trust), near, closed, now, (now * normals).sum(1))

    @cached_property
    def _adjacency(self):
        return vertex_neighbours(self.faces, len(self.neutral))[0]


@dataclass(frozen=True, eq=False)
class Motion:
    """One expression, from the neutral face (start included).

    triangles (m,) that change; maps (m, 3, 3) of them; moved (V, 3) displacements; trust (V,) from 0 where nothing
    moves to 1; near (V,) 1 where something moves, falling to 0 around it; closed (P,) pairs that come together; offsets
    (P, 3) between the vertices of pairs; gaps (P,) along their normals in the neutral face.
    """

    triangles: np.ndarray
    maps: np.ndarray
    moved: np.ndarray
    trust: np.ndarray
    near: np.ndarray
    closed: np.ndarray
    offsets: np.ndarray
    gaps: np.ndarray


def start_delta(names, deltas, k):
    """What expression k is added to besides the neutral face: the displacements of another one (V, 3), or 0."""
    base = STARTS.get(names[k])
    return deltas[names.index(base)] if base in names else 0.0


def combined_templates(templates, expressions):
    """ExpressionTemplates of combinations. expressions: dict from names to dicts of names of templates to weights."""
    known = dict(zip(templates.names, templates.deltas, strict=True))
    none = np.zeros_like(templates.neutral)
    deltas = [sum((w * known[name] for name, w in weights.items()), none) for weights in expressions.values()]
    return ExpressionTemplates(tuple(expressions), templates.neutral, templates.faces, np.array(deltas))


def check_templates(names, neutral, faces, shapes):
    """ExpressionTemplates of shapes (K, V, 3), or InputError where the mesh is none to transfer from."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    shared = np.unique(edges, axis=0, return_counts=True)[1].max()
    if shared > 2:
        raise InputError(f"expected at most two triangles on every edge, found {shared} on one")
    unused = len(neutral) - len(np.unique(faces))
    if unused:
        raise InputError(f"expected every vertex in a triangle, found {unused} without")
    areas = np.linalg.norm(triangle_normals(neutral, faces), axis=1)
    if areas.min() <= _FLAT * areas.mean():
        raise InputError(f"expected triangles with an area, found {(areas <= _FLAT * areas.mean()).sum()} without")
    return ExpressionTemplates(tuple(names), neutral, faces, shapes - neutral)


def mended_templates(head, template):
    """The 52 expressions of the open head, its lids and lips stopped where they meet.

    The head's blinks close the lids at about 0.8, sooner at the outer than at the inner corner, and pierce beyond: at
    that strength the margins are brought together. Elsewhere lips that push through each other are held apart.

    head: Head. template: Template of its neutral face.
    Returns ExpressionTemplates.
    """
    neutral, faces = template.vertices, template.faces
    raw = head.actions.astype(float)
    templates = ExpressionTemplates(head.action_names, neutral, faces, raw)
    curves = template.annotation.curves
    lids = {side: np.stack([curves[f"eye_{lid}_{side}"][1:-1] for lid in ("upper", "lower")], 1)
            for side in ("left", "right")}  # fmt: skip
    groups = lids | {"lips": touching_pairs(neutral, faces, templates.reach)}
    pairs, kinds = np.concatenate([*groups.values()]), np.repeat([*groups], [len(rows) for rows in groups.values()])
    adjacency, _ = vertex_neighbours(faces, len(neutral))
    transfer = DeformationTransfer(neutral, faces, templates.still)
    solver = ContactSolver(transfer, pairs)
    normals = contact_normals(neutral, faces, pairs, templates.reach)
    offsets = neutral[pairs[:, 0]] - neutral[pairs[:, 1]]
    gaps = (offsets * normals).sum(1)
    floors = np.minimum(gaps, _TOUCH) - gaps
    # Margins of lids meet in a line; lips lie on each other, and what is between their vertices sideways stays.
    met = np.where(kinds[:, None] == "lips", floors[:, None] * normals, -offsets)
    deltas = np.zeros_like(raw)
    for k, name in enumerate(head.action_names):
        moved = STRENGTH.get(name, 1.0) * raw[k]
        # mouthClose alone pushes the lips through each other: it undoes an opening that is not there.
        start = templates.start(k) - neutral
        closed = np.array([name.lower() == f"eyeblink{kind}" for kind in kinds])
        if name == "mouthClose":
            then, now = (offsets + v[pairs[:, 0]] - v[pairs[:, 1]] for v in (start, start + moved))
            came = closes(np.linalg.norm(then, axis=1), np.linalg.norm(now, axis=1), templates.reach)
            closed = came & (kinds == "lips")
        correction = solver.solve(start + moved, closed, met, normals, floors) - start - moved
        # What the condition moves apart or together, and what the action moves by itself; the rest of the head stays.
        parted = np.linalg.norm(correction[pairs[:, 0]] - correction[pairs[:, 1]], axis=1) > _NOTICED
        seeds = (np.abs(start + moved) > _STILL * np.ptp(neutral[:, 1])).any(1)
        seeds[pairs[parted]] = True
        deltas[k] = moved + _fading(seeds, adjacency)[:, None] * correction
    return ExpressionTemplates(head.action_names, neutral, faces, deltas)


def _fading(seeds, adjacency):
    """(V,) 1 at the seeds (V,) bool, falling to 0 over ``_FADE`` edges around them."""
    near = seeds.astype(float)
    for ring in range(_FADE):
        near = np.maximum(near, (1 - (ring + 1) / (_FADE + 1)) * (adjacency @ near > 0))
    return near


def thinned(pairs, vertices, spacing):
    """One pair for every two cells of space that pairs join, so that finer meshes do not have more of them."""
    cells = np.floor(vertices[pairs] / spacing).astype(np.int64).reshape(len(pairs), 6)
    return pairs[np.sort(np.unique(cells, axis=0, return_index=True)[1])]


def contact_normals(vertices, faces, pairs, reach, usual=None):
    """(P, 3) unit directions from the second to the first vertex of pairs, by their normals where they touch.

    usual: (P, 3) unit directions, taken where those of crumpled lips point elsewhere; or None.
    """
    around = igl.per_vertex_normals(vertices, faces)
    offsets = vertices[pairs[:, 0]] - vertices[pairs[:, 1]]
    touching = np.linalg.norm(offsets, axis=1, keepdims=True) < reach
    directions = np.where(touching, around[pairs[:, 1]] - around[pairs[:, 0]], offsets)
    directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-12)
    if usual is None:
        return directions
    return np.where((directions * usual).sum(1, keepdims=True) > _AGREES, directions, usual)
