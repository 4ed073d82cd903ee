"""Parts that are as rigid as bone."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from caricli.geometry.alignment.axis_similarity import axis_similarity
from caricli.methods.parts.clear_way import Bends, clear_way
from caricli.methods.parts.flesh import Flesh, Hide
from caricli.methods.parts.follow import follow_weights
from caricli.methods.parts.frames import Frames, surroundings
from caricli.methods.parts.guides import Guides
from caricli.methods.parts.incisors import BEHIND_LIPS, Incisors, incisors_of, lip_middles
from caricli.methods.parts.jaw import STILL, Jaw
from caricli.methods.parts.let_out import PARTINGS, far_enough, part_more, tongue_bends, towards_gap
from caricli.methods.parts.make_room import YIELDING, RoomSettings, make_room, room_moves
from caricli.methods.parts.pocket import Mouth, Mouths
from caricli.methods.parts.posed import Posed
from caricli.structures import Material, Part
from caricli.template.template import Template

UNEVEN = 1.5
"""How many times as wide as high, or deep, a part may become, compared with the template's."""

OWN = 5e-3
"""Metres: a part that an expression of the template moves less against its bone is taken to be as rigid as that."""

PRESSED = 0.001
"""Of the head's height: nothing comes nearer to the wall of the mouth than this."""

UPPER = RoomSettings(margin=0.003, bent=10.0)
"""Of upper teeth, which show most: the rim of a lip that rolls in pushes those that are bent forward."""

WAY = (0.25, 0.5, 0.75, 1.0)
"""Weights of expressions at which parts are kept out of the skin."""

SHIFT = 0.1
"""Weight against moves of what is firm, to one point that is as deep."""

GIVEN_WAY = 3
"""How often what gives way is looked at, at all weights."""

FREE = 1.0
"""Times PRESSED, what the worst point of a tongue may lack of that distance where lips are parted far enough."""

AROUND = 0.02
"""Of the head's height: how far points are from the one that tells whether the wall may be near them."""

_FIRM = 80
"""Points of what does not give way that are looked at."""


@dataclass(frozen=True, eq=False)
class _AtRest:
    """A part without expression.

    shape: (W, 3) metres. distance: (W,) metres from the wall of the mouth. bends: (W, 3, M), what it can do to make
    room in an expression, of amounts of a metre.
    """

    shape: np.ndarray
    distance: np.ndarray
    bends: np.ndarray


class Bone:
    """A part that stands by what surrounds it, and that expressions move as rigidly as they move the jaw.

    It is turned and scaled along its width, height and depth, and bent only to make room for the wall of the mouth: in
    an expression the back of an arch becomes narrower where cheeks do not let the molars down with the jaw.
    """

    def __init__(self, template: Template, part: Part, frames: Frames, jaw: Jaw | None) -> None:
        """frames: of the part. jaw: what it moves with, None for the skull, which keeps still."""
        self.part = part
        self.shape = np.asarray(part.mesh.vertices, float)
        self.frames = frames
        self.jaw = jaw
        self.hide = Hide(template.faces)
        self.lips = _lips(template)
        self.middles = lip_middles(template)
        self.incisors = incisors_of(template, part)
        self.around = surroundings(template, part)
        anchors = np.asarray(template.vertices, float)[self.around]
        skin, moved = frames.examples
        examples = (skin[:, self.around] if len(skin) else np.zeros((0, len(anchors), 3)), moved)
        self.weights = follow_weights(anchors, frames.points, examples, template.height)
        teeth = np.unique(part.mesh.polygons[part.materials == Material.TEETH])
        # Gums and tongue give way where teeth do not.
        firm = teeth[teeth >= 0] if len(teeth) else np.arange(len(self.shape))
        self.firm = firm[:: max(len(firm) // _FIRM, 1)]
        self.room = UPPER if self.incisors is not None and not self.incisors.row else RoomSettings()
        self.moves = room_moves(self.shape, self.firm)
        self.guides = Guides(self.shape, AROUND * template.height)

    def place(self, face: Posed, mouths: Mouths | None) -> Part:
        """The part in a face. mouths: of the same face, None where the wall of its mouth is not told."""
        shape, to_face = self._at_rest(face, mouths)
        moved = self._moved(face, shape, to_face)
        if mouths is not None and face.names:
            bends = (self.moves[:, YIELDING] @ to_face.T).transpose(0, 2, 1)
            rest = _AtRest(shape, mouths.rest.room(shape)[0], bends)
            for k in mouths.order:
                if self._comes_out(face.weights[k]) > 0:
                    moved[k] += self._way_out(face.only(k), shape, moved[k], mouths.height)[0]
                else:
                    moved[k] += self._kept_in(mouths, rest, moved, int(k))
        return replace(self.part, mesh=self.part.mesh.with_vertices(shape), names=face.names, deltas=moved)

    def let_out(self, face: Posed, mouths: Mouths) -> np.ndarray:
        """(K, V, 3) metres, what expressions do to a face whose lips part as far as the part needs to come out."""
        shape, to_face = self._at_rest(face, mouths)
        lips = part_more(face.names, face.deltas)
        deltas = face.deltas.copy()
        for k, weights in enumerate(face.weights):
            if self._comes_out(weights) <= 0:
                continue
            least = np.inf
            for parting in PARTINGS:
                opened = Posed(face.neutral, face.only(k).expressions, (face.deltas[k] + parting * lips)[None])
                _, lack = self._way_out(opened, shape, self._moved(opened, shape, to_face)[0], mouths.height)
                if lack < least:
                    least = lack
                    deltas[k] = opened.deltas[0]
                if least <= FREE * PRESSED * mouths.height:
                    break
        return deltas

    def _at_rest(self, face: Posed, mouths: Mouths | None) -> tuple[np.ndarray, np.ndarray]:
        """The part (W, 3) without expression, and what (3, 3) takes it there."""
        shape, to_face = self._follow(face.neutral)
        if mouths is None:
            return shape, to_face
        if self.incisors is not None:
            up = to_face[:, 1] / np.linalg.norm(to_face[:, 1])
            shape = self._with_teeth(self.incisors, face, shape, up, mouths.height)
        return self._settled(mouths.rest, shape, to_face, mouths.height), to_face

    def _follow(self, skin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The part (W, 3) where the skin (V, 3) around it says, and what (3, 3) takes it there."""
        scales, rotation, shift = axis_similarity(self.frames.points, self.weights @ skin[self.around], UNEVEN)
        to_face = rotation * scales
        return self.shape @ to_face.T + shift, to_face

    def _with_teeth(
        self, incisors: Incisors, face: Posed, shape: np.ndarray, up: np.ndarray, height: float
    ) -> np.ndarray:
        """The part (W, 3) with its teeth as far up (3,) that lips show them as they do."""
        shown = 0.0 if face.teeth is None else float(face.teeth[incisors.row])
        if face.teeth is not None and face.given is None:
            return incisors.as_pictured(face.neutral, shape, up, shown, height)
        shape = incisors.grown(shape, up, shown, BEHIND_LIPS)
        if incisors.row:
            return shape + incisors.lifted(face.neutral, shape, up, height) * up
        return shape + self._shown(incisors, face, shape, up, height) * up

    def _shown(self, incisors: Incisors, face: Posed, shape: np.ndarray, up: np.ndarray, height: float) -> float:
        """Metres, at most 0, by which the upper teeth (W, 3) go up (3,) so that lips show them as they do."""
        highest = incisors.highest(face.neutral, shape, up, height)
        if face.given is not None:
            given, _ = self._follow(face.given)
            end = min(incisors.edge(given, up), incisors.highest(face.given, given, up, height))
            highest = min(highest, max(end, incisors.lowest(face.neutral, up, height)))
        return min(highest - incisors.edge(shape, up), 0.0)

    def _moved(self, face: Posed, shape: np.ndarray, to_face: np.ndarray) -> np.ndarray:
        """(K, W, 3) what expressions do to the part by the jaw and by themselves."""
        moved = np.zeros((len(face.names), *shape.shape))
        for k, weights in enumerate(face.weights):
            if self.jaw is not None:
                turn, carry = self.jaw.motion([*weights], face.neutral, face.deltas[k])
                moved[k] = shape @ turn.T + carry - shape
            for action, own in self.own.items():
                moved[k] += weights.get(action, 0.0) * own @ to_face.T
        return moved

    def _comes_out(self, weights: Mapping[str, float]) -> float:
        """How much of its own way it goes in an expression. weights: of actions, by name."""
        return max((weights.get(action, 0.0) for action in self.own), default=0.0)

    def _settled(self, mouth: Mouth, shape: np.ndarray, to_face: np.ndarray, height: float) -> np.ndarray:
        """The part (W, 3) brought into a mouth, and what gives way pressed into it. to_face: (3, 3), what turned it."""
        near = self._near(mouth, shape, PRESSED * height)
        if mouth.room(shape[np.intersect1d(near, self.firm)])[0].min(initial=np.inf) < PRESSED * height:
            moves = self.moves @ to_face.T
            amounts = make_room(mouth, shape[self.firm], moves[self.firm], self.room.margin * height, self.room)
            shape = shape + moves.transpose(0, 2, 1) @ amounts
            near = self._near(mouth, shape, PRESSED * height)
        settled = shape.copy()
        settled[near] += mouth.pushes(shape[near], PRESSED * height)
        return settled

    def _near(self, mouth: Mouth, shape: np.ndarray, margin: float) -> np.ndarray:
        """Ids of those of the part (W, 3) that may be nearer than so many metres to the wall of a mouth."""
        return self.guides.near(shape, margin, lambda guides: mouth.room(guides)[0])

    def _kept_in(self, mouths: Mouths, rest: _AtRest, moved: np.ndarray, k: int) -> np.ndarray:
        """(W, 3) what expression k has to do besides, so that the part stays in the mouth on the way.

        moved: (K, W, 3) metres, what all do.
        """
        shape, distance = rest.shape, rest.distance
        more = np.zeros_like(shape)
        way = np.tensordot(mouths.uses[k], moved, 1)
        # What the wall cannot come near on its way need not be looked at.
        reach = np.linalg.norm(way, axis=1) + mouths.moves(k)
        free = distance - reach
        touch = PRESSED * mouths.height
        # What lacks at rest no expression makes good: many of them at once would do so many times.
        least = np.minimum(distance, touch)
        near = np.flatnonzero((free < least) & (reach > STILL))
        firm = np.intersect1d(near, self.firm)
        walls = {amount: mouths.mouth(k, amount) for amount in WAY} if len(near) else {}
        # Mostly it is the end that touches.
        ends = reversed(walls.items())
        if any((wall.room(shape[firm] + amount * way[firm])[0] < least[firm]).any() for amount, wall in ends):
            points, ways = shape[self.firm], way[self.firm]
            margin = self.room.margin * mouths.height
            amounts, _ = clear_way(walls, points, ways, _free(rest.bends[self.firm]), margin, distance[self.firm])
            more += rest.bends @ amounts
            near = np.flatnonzero(free - np.linalg.norm(more, axis=1) < least)
        for _ in range(GIVEN_WAY):
            pressed = np.zeros(len(near), bool)
            for amount, wall in walls.items():
                # On the way it may touch: what is pressed there goes much farther at its end.
                margins = np.minimum(least[near], touch if amount == 1 else -touch)
                push = wall.pushes(shape[near] + amount * (way + more)[near], margins)
                more[near] += push / amount
                pressed |= push.any(1)
            near = near[pressed]
            if not len(near):
                break
        return more

    def _way_out(self, face: Posed, shape: np.ndarray, move: np.ndarray, height: float) -> tuple[np.ndarray, float]:
        """(W, 3) what a part that comes out of the mouth has to do besides, so that it does between the lips.

        face: Posed with one expression, which moves the part (W, 3) by itself. height: metres, as of ``Mouths``.
        Returns also what the worst point lacks of its distance from the skin, metres.
        """
        flesh = {amount: Flesh(self.hide, face.neutral + amount * face.deltas[0]) for amount in WAY}
        share = self._comes_out(face.weights[0])
        skin = face.neutral + face.deltas[0]
        whole, spare = far_enough(shape, move / share, skin[self.lips], height)
        way = share * whole
        higher = 0.0 if self.middles is None else towards_gap(shape, way, *skin[self.middles, 1])
        bends = tongue_bends(shape, way, share * spare, higher)
        amounts, lack = clear_way(flesh, shape, way, bends, PRESSED * height)
        return way - move + bends.moves @ amounts, lack

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


def _lips(template: Template) -> np.ndarray:
    """Vertex ids of the rims of the lips, or of the whole mouth where these are not told."""
    curves = template.annotation.curves
    rims = [curves[name] for name in ("mouth_inner_upper", "mouth_inner_lower") if name in curves]
    return np.concatenate(rims) if rims else template.region("mouth")


def _free(moves: np.ndarray) -> Bends:
    """Moves (N, 3, M) of points, which have no bounds."""
    count = moves.shape[2]
    return Bends(moves, np.full(count, SHIFT), np.full(count, -np.inf), np.zeros(count))
