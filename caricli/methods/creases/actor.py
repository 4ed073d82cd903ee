"""A person who shows expressions, with all that these do to shape and paint."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from caricli.data.albedo import AlbedoPainter
from caricli.data.appearance import Appearance, random_appearance
from caricli.methods.creases.crease_pattern import CreasePattern, random_pattern
from caricli.methods.creases.creased_skin import CreasedSkin, CreaseGround
from caricli.methods.creases.flushed_skin import FlushedSkin
from caricli.methods.creases.relief import ReliefMaker
from caricli.methods.pictures.eyes import Eyes
from caricli.methods.pictures.piece import Piece, join_pieces, make_piece
from caricli.methods.pictures.settings import SitterSettings
from caricli.methods.pictures.sitter import Shadows, Sitter, Wardrobe, part_piece
from caricli.render.eyes.place_eyeballs import place_eyeballs
from caricli.render.pixels.srgb import to_linear, to_srgb
from caricli.render.sky import sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Part
from caricli.structures.arkit import alone
from caricli.structures.landmarks import COUNT, JAW, POINT_NAMES
from caricli.structures.parsing import Region
from caricli.template.template import Template

_WORN = SitterSettings(bald=0.4, shaved=0.1, hat=0.06, beard=0.15)
"""How often people wear hair and hats: seldom enough that most foreheads are seen."""


@dataclass(frozen=True, eq=False)
class Actor:
    """How one person looks, whatever the expression.

    appearance: Appearance. pattern: CreasePattern. colours: (P, 3) linear, of the fine skin. gloss: of the skin. iris:
    (3,) linear. reach: radians, of the iris. white: (3,) factors of the teeth. worn: hair and hat. seed: of the beard.
    """

    appearance: Appearance
    pattern: CreasePattern
    colours: np.ndarray
    gloss: float
    iris: np.ndarray
    reach: float
    white: np.ndarray
    worn: list[Piece]
    seed: int


@dataclass(frozen=True, eq=False)
class Act:
    """One expression of a person. shape: (V, 3) metres. weights: of actions."""

    shape: np.ndarray
    weights: Mapping[str, float]


class Stage:
    """What all people who act share, prepared once."""

    def __init__(self, template: Template) -> None:
        """template: of the faces, with lips, brows and a face's landmarks."""
        self.template = template
        self.wardrobe = Wardrobe(template, _WORN)
        attachment = self.wardrobe.attachment
        self.attachment = None if attachment is None else attachment.without_lashes()
        self.changing = template.mask("lips", "inner_mouth", "eyes_left", "eyes_right")
        painter: AlbedoPainter = self.wardrobe.painter
        self.marks = painter.marks[:COUNT, :2]
        corners = [POINT_NAMES["eye_outer_right"], POINT_NAMES["eye_outer_left"]]
        self.unit = float(np.linalg.norm(np.subtract(*template.vertices[template.annotation.landmarks[corners]])))
        front = float(painter.marks[[JAW[0], JAW[-1]], 2].mean())
        self.ground = CreaseGround(self.wardrobe.fine, painter.places, front)
        self.flushed = FlushedSkin(painter)

    def engage(self, neutral: np.ndarray, age: float, deep: float, generator: np.random.Generator) -> Actor:
        """Draw an Actor. neutral: (V, 3) metres. age: of the skin, 0 to 1. deep: factor of the depth of folds."""
        appearance = random_appearance(generator)
        worn, scalp = self.wardrobe.headwear(self.template.with_vertices(neutral), appearance, generator)
        appearance = replace(appearance, scalp=scalp)
        return Actor(
            appearance,
            random_pattern(self.marks, age, generator).deepened(deep),
            to_linear(self.wardrobe.painter.draw(appearance)),
            float(generator.uniform(0, 0.4)),
            generator.random(3) ** 2 * generator.uniform(0.1, 0.6),
            float(generator.uniform(0.34, 0.62)),
            generator.uniform([0.85, 0.8, 0.65], [1.05, 1.03, 1.0]),
            worn,
            int(generator.integers(2**32)),
        )

    def perform(
        self, actor: Actor, neutral: np.ndarray, shapes: np.ndarray, weights: Sequence[Mapping[str, float]]
    ) -> list[Sitter]:
        """Show expressions.

        neutral: (V, 3) metres. shapes: (E, V, 3) metres, with the expressions. weights: E times those of actions.
        """
        names = [str(k) for k in range(len(shapes))]
        parts: Sequence[Part] = ()
        if self.attachment is not None:
            parts = self.attachment.animate(self.template.with_vertices(neutral), alone(names), shapes - neutral)
        shadows = Shadows(self._sky(actor, neutral), self.changing, sum(len(part.mesh.vertices) for part in parts))
        maker = ReliefMaker(actor.pattern)
        return [
            self._sitter(actor, [_moved(part, k) for part in parts], Act(shape, weights[k]), maker, shadows)
            for k, shape in enumerate(shapes)
        ]

    def _sky(self, actor: Actor, neutral: np.ndarray) -> np.ndarray:
        """(V, D) what of the sky the skin sees past what is worn."""
        bare = make_piece(neutral, self.template.faces, Region.SKIN, np.zeros(3))
        whole = join_pieces([bare, *actor.worn])
        normals = smooth_normals(whole.vertices, whole.faces)
        return sky_visibility(whole.vertices, whole.faces, normals, np.arange(len(neutral)))

    def _sitter(self, actor: Actor, parts: list[Part], act: Act, maker: ReliefMaker, shadows: Shadows) -> Sitter:
        wardrobe = self.wardrobe
        head = self.template.with_vertices(act.shape)
        vertices = wardrobe.fine.weights @ act.shape
        colours = actor.colours * self.flushed.factors(act.weights, actor.pattern.flush)
        skin = make_piece(vertices, wardrobe.fine.mesh.faces, wardrobe.regions, colours, actor.gloss)
        pieces = [skin, *(part_piece(part, actor.white) for part in parts)]
        beard = wardrobe.beard(skin, actor.appearance, np.random.default_rng(actor.seed))
        together = join_pieces([*pieces, *actor.worn, *beard])
        normals, transfer = wardrobe.light_transfer(head, together, len(vertices), shadows)
        eyes = Eyes(place_eyeballs(head, self.template.annotation), actor.iris, actor.reach)
        creases = CreasedSkin.of(self.ground, maker.relief(act.weights), vertices, self.unit)
        return Sitter(head, together, normals, transfer, eyes, to_srgb(colours[: len(act.shape)]), creases)


def _moved(part: Part, number: int) -> Part:
    """A part as one of its expressions has it."""
    return replace(part, mesh=part.mesh.with_vertices(part.mesh.vertices + part.deltas[number]))
