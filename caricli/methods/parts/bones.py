"""Parts that are as rigid as bone."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from caricli.geometry.axis_similarity import axis_similarity
from caricli.geometry.weighted_similarities import weighted_similarities
from caricli.methods.parts.follow import follow_weights
from caricli.methods.parts.pocket import Mouth, Mouths, bend_out, make_room
from caricli.structures import Material, Part
from caricli.template.template import Template

RIGID = 0.002
"""Of the head's height: skin that moves so much otherwise than the bone says half as much of it."""

UNEVEN = 1.5
"""How many times as wide as high, or deep, a part may become, compared with the template's."""

OWN = 5e-3
"""Metres: a part that an expression of the template moves less against its bone is taken to be as rigid as that."""

STILL = 1e-4
"""Metres: what an expression of the template moves less it leaves where it is."""


PRESSED = 0.001
"""Of the head's height: nothing comes nearer to the wall of the mouth than this, and"""
KEPT = 0.003
"""teeth that would are moved as far from it."""

WAY = (0.5, 1.0)
"""Weights of expressions at which the wall of the mouth is looked at, the one that must be right last."""

LET_OUT = (0.25, 0.5, 0.75, 1.0)
"""The same for what comes out of it."""

_FIRM = 80
"""Points of what does not give way that are looked at."""

_FEWEST = 12
"""Vertices of a region that can tell where a part is."""

_MOST = 500
"""Vertices of the skin that are asked."""

_POINTS = 80
"""Of a part, that are asked for."""


@dataclass(frozen=True, eq=False)
class Posed:
    """The skin of a face and its expressions.

    neutral: (V, 3) metres. names: K. deltas: (K, V, 3) metres.
    """

    neutral: np.ndarray
    names: tuple[str, ...]
    deltas: np.ndarray


@dataclass(frozen=True, eq=False)
class Frames:
    """Points in a part, and how heads differ there.

    points: (Q, 3) metres, in the template. examples: displacements (n, V, 3) of the skin and (n, Q, 3) of the points
    from the template to other heads; n may be 0.
    """

    points: np.ndarray
    examples: tuple[np.ndarray, np.ndarray]


def plain_frames(part: Part) -> Frames:
    """Frames of a part of which nothing but its place is known: points spread over it."""
    vertices = np.asarray(part.mesh.vertices, float)
    points = vertices[np.linspace(0, len(vertices) - 1, min(_POINTS, len(vertices))).astype(int)]
    return Frames(points, (np.zeros((0, 0, 3)), np.zeros((0, len(points), 3))))


class Bone:
    """A part that stands by what surrounds it, and that expressions move as rigidly as they move the jaw.

    It is turned and scaled along its width, height and depth, never bent.
    """

    def __init__(self, template: Template, part: Part, frames: Frames, jaw: "Jaw | None") -> None:
        """frames: of the part. jaw: what it moves with, None for the skull, which keeps still."""
        self.part = part
        self.shape = np.asarray(part.mesh.vertices, float)
        self.frames = frames
        self.jaw = jaw
        self.around = surroundings(template, part)
        anchors = np.asarray(template.vertices, float)[self.around]
        skin, moved = frames.examples
        examples = (skin[:, self.around] if len(skin) else np.zeros((0, len(anchors), 3)), moved)
        self.weights = follow_weights(anchors, frames.points, examples, template.height)
        teeth = np.unique(part.mesh.polygons[part.materials == Material.TEETH])
        # Gums and tongue give way where teeth do not.
        firm = teeth[teeth >= 0] if len(teeth) else np.arange(len(self.shape))
        self.firm = firm[:: max(len(firm) // _FIRM, 1)]

    def place(self, face: Posed, mouths: Mouths | None) -> Part:
        """The part in a face. mouths: of the same face, None where the wall of its mouth is not told."""
        scales, rotation, shift = axis_similarity(self.frames.points, self.weights @ face.neutral[self.around], UNEVEN)
        to_face = rotation * scales
        shape = self.shape @ to_face.T + shift
        if mouths is not None:
            shape = self._settled(mouths.rest, shape, mouths.height, True)
        moved = self._moved(face, shape, to_face)
        if mouths is not None:
            for k in mouths.order:
                moved[k] += self._kept_in(mouths, shape, moved, int(k))
        return replace(self.part, mesh=self.part.mesh.with_vertices(shape), names=face.names, deltas=moved)

    def _moved(self, face: Posed, shape: np.ndarray, to_face: np.ndarray) -> np.ndarray:
        """(K, W, 3) what expressions do to the part by the jaw and by themselves."""
        moved = np.zeros((len(face.names), *shape.shape))
        for k, name in enumerate(face.names):
            if self.jaw is not None:
                turn, carry = self.jaw.motion(name, face.neutral, face.deltas[k])
                moved[k] = shape @ turn.T + carry - shape
            if name in self.own:
                moved[k] += self.own[name] @ to_face.T
        return moved

    def _settled(self, mouth: Mouth, shape: np.ndarray, height: float, scaling: bool) -> np.ndarray:
        """The part (W, 3) as a whole brought into a mouth, and what gives way pressed into it."""
        firm = shape[self.firm]
        settled = shape
        if mouth.room(firm)[0].min() < PRESSED * height:
            scale, shift = make_room(mouth, firm, KEPT * height, scaling)
            centre = firm.mean(0)
            settled = centre + scale * (shape - centre) + shift
        return settled + mouth.pushes(settled, PRESSED * height)

    def _kept_in(self, mouths: Mouths, shape: np.ndarray, moved: np.ndarray, k: int) -> np.ndarray:
        """(W, 3) what expression k has to do besides, so that the part stays in the mouth on the way."""
        more = np.zeros_like(shape)
        if mouths.still(k) and not moved[k].any():
            return more
        if mouths.names[k] in self.own:
            return self._let_out(mouths, shape, moved[k], k)
        for amount in WAY:
            start = shape + amount * np.tensordot(mouths.uses[k], moved, 1)
            posed = start + amount * more
            settled = self._settled(mouths.mouth(k, amount), posed, mouths.height, False)
            more += (settled - posed) / amount
        return more

    def _let_out(self, mouths: Mouths, shape: np.ndarray, move: np.ndarray, k: int) -> np.ndarray:
        """(W, 3) what a part that comes out of the mouth has to do besides, so that it does between the lips."""
        opened = {weight: mouths.mouth(k, weight, True) for weight in LET_OUT}
        return bend_out(opened, shape, move, PRESSED * mouths.height)

    @cached_property
    def own(self) -> dict[str, np.ndarray]:
        """What expressions of the template do to the part beside moving it with the jaw, (W, 3) by name."""
        moves = {}
        for name, delta in zip(self.part.names, np.asarray(self.part.deltas, float), strict=True):
            if self.jaw is not None and self.jaw.moves(name):
                turn, shift = self.jaw.usual[name]
                delta = delta - (self.shape @ turn.T + shift - self.shape)
            if np.abs(delta).max() > OWN:
                moves[name] = delta
        return moves


class Jaw:
    """The motion of the jaw's bone, read from the skin that moves with it."""

    def __init__(self, template: Template, part: Part, actions: np.ndarray) -> None:
        """part: that hangs on the jaw and is rigid, with its expressions. actions: (K, V, 3) metres, what the same
        expressions do to the skin."""
        start = np.asarray(part.mesh.vertices, float)
        vertices = np.asarray(template.vertices, float)
        self.names = part.names
        self.anchors: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        if not len(self.names):
            ids = template.region("jaw")
            self.shared = (ids, np.ones(len(ids)))
            return
        self.moving = np.abs(np.asarray(part.deltas)).max((1, 2)) > STILL
        _, turns, shifts = weighted_similarities(start, start + part.deltas, np.ones(len(start)), scaling=False)
        with_bone = vertices @ np.swapaxes(turns, -1, -2) + shifts[:, None] - vertices
        apart = np.linalg.norm(actions - with_bone, axis=-1) / (RIGID * template.height)
        moving = np.linalg.norm(with_bone, axis=-1) / (RIGID * template.height)
        # What hardly moves with the bone, near the joint, must not outweigh the chin because it is hardly apart.
        own = 1 / (1 + apart**4) * np.minimum(moving, 1)
        shared = 1 / (1 + apart.max(0) ** 2) ** 2 * np.minimum(moving.max(0), 1)
        self.anchors = {name: _largest(own[k]) for k, name in enumerate(self.names) if self.moving[k]}
        self.usual = {name: (turns[k], shifts[k]) for k, name in enumerate(self.names)}
        self.shared = _largest(shared)

    def moves(self, name: str) -> bool:
        """Whether an expression of the template moves the bone."""
        return name in self.anchors

    def motion(self, name: str, neutral: np.ndarray, delta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotation (3, 3) and translation (3,) of the bone of a face (V, 3) in an expression (V, 3)."""
        if name in self.names and not self.moves(name):
            return np.eye(3), np.zeros(3)
        ids, weights = self.anchors.get(name, self.shared)
        start = neutral[ids]
        _, turn, shift = weighted_similarities(start, start + delta[ids], weights, scaling=False)
        return turn, shift


def surroundings(template: Template, part: Part) -> np.ndarray:
    """Vertices of the skin that say where a part is: the wall of the mouth, or else what it hangs on."""
    regions = template.annotation.regions
    ids = regions.get("inner_mouth", np.zeros(0, int))
    if len(ids) < _FEWEST:
        ids = regions.get(part.hangs_on, np.zeros(0, int))
    if len(ids) < _FEWEST:
        distance = np.linalg.norm(template.vertices - part.mesh.vertices.mean(0), axis=1)
        ids = np.argsort(distance, kind="stable")
    return ids[:: -(-len(ids) // _MOST)]


def _largest(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ids of the vertices that count, and their weights."""
    ids = np.flatnonzero(weights > 1e-2 * weights.max())
    return ids, weights[ids]
