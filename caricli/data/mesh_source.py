"""The meshes of a generated dataset: people with expressions, exaggerated."""

from dataclasses import dataclass, field

import numpy as np

from caricli.data.attributes import measure_attributes
from caricli.data.build_settings import DRAW, EXPONENTS, BuildSettings, Exaggeration
from caricli.data.exaggerate_parts import exaggerate_parts
from caricli.data.expressions import named_expressions
from caricli.data.identities import random_identity
from caricli.data.move_parts import NAMES, POINTS, random_hand, random_part_changes
from caricli.data.regular_face import Person, align_person, regular_face
from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import untangle
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.seeds import DatasetSeed
from caricli.template.annotation import DELICATE
from caricli.template.head import load_head

STRANGERS = 1_000_000
"""Number of the first person who is only in the prior: above all that a dataset can have."""


Prior = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Mean, basis and offset of the IntrinsicModel that parts are exaggerated with."""


@dataclass(frozen=True, eq=False)
class Recipe:
    """What a mesh is made of.

    identity, expression: numbers. level: of exaggeration by curvature, 0 is none. kind: Exaggeration. parts: changes
    in the order of ``move_parts.NAMES``. hand: (81, 3) metres, moves of the landmarks beside these.
    """

    identity: int
    expression: int
    level: int = 0
    kind: Exaggeration = Exaggeration(0)
    parts: np.ndarray = field(default_factory=lambda: np.zeros(len(NAMES)))
    hand: np.ndarray = field(default_factory=lambda: np.zeros((POINTS, 3)))


@dataclass(frozen=True, eq=False)
class DatasetRow:
    """One mesh of a dataset.

    columns: values by the names of a shard's columns. measures: attributes by name. flipped: share of the triangles.
    """

    columns: dict[str, np.ndarray | int | float]
    measures: dict[str, float]
    flipped: float


class MeshSource:
    """Makes meshes by their numbers; what all of them need is made once."""

    def __init__(self, settings: BuildSettings, prior: Prior | None = None) -> None:
        """prior: where parts are exaggerated."""
        self.settings = settings
        self.head = load_head()
        self.template = self.head.template()
        self.face = self.template.region("face")
        self.actions = list(named_expressions(self.head.action_names).values())[: settings.expressions]
        self.hold = self.template.mask(*DELICATE).astype(float)
        self.model = IntrinsicModel(self.template, *prior) if prior else None
        self._people: dict[int, Person] = {}

    def person(self, number: int) -> Person:
        """The person of a number, whose neutral face has no flipped triangle."""
        if number not in self._people:
            generator = self._generator(DatasetSeed.IDENTITY, number)
            for _ in range(DRAW.person_tries):
                identity = random_identity(self.head, generator)
                neutral = self.head.evaluate(**vars(identity))
                if not flipped_triangles(neutral, self.template.gradients).any():
                    break
            self._people[number] = align_person(identity, neutral, self.template)
        return self._people[number]

    def prior_shape(self, number: int) -> np.ndarray:
        """(1, V, 3) a face of the prior: someone who is not in the dataset, exaggerated by curvature at random."""
        generator = self._generator(DatasetSeed.PRIOR, number)
        vertices = self._regular(STRANGERS + number, int(generator.integers(self.settings.expressions)))
        return self._by_curvature(vertices, [generator.uniform(0, EXPONENTS[-1])])

    def levels(self, identity: int, expression: int) -> list[DatasetRow]:
        """A person with an expression at every level of exaggeration by curvature."""
        shapes = self._by_curvature(self._regular(identity, expression), EXPONENTS[: self.settings.levels])
        kinds = [Exaggeration(0)] + [Exaggeration.CURVATURE] * (len(shapes) - 1)
        recipes = [Recipe(identity, expression, level, kind) for level, kind in enumerate(kinds)]
        return [self._row(vertices, recipe) for vertices, recipe in zip(shapes, recipes, strict=True)]

    def draw(self, number: int) -> DatasetRow:
        """One random mesh; redrawn with milder changes while too many triangles flip."""
        generator = self._generator(DatasetSeed.DRAW, number)
        kind = Exaggeration(int(generator.choice(len(DRAW.shares), p=DRAW.shares)))
        if self.settings.levels == 1:
            kind = Exaggeration(0)
        strength = generator.uniform(*DRAW.strength)
        for _ in range(DRAW.tries):
            vertices, recipe = self._draw_once(generator, kind, strength)
            if self._flipped(vertices) <= DRAW.max_flipped:
                break
            strength *= DRAW.milder
        return self._row(vertices, recipe)

    def _draw_once(
        self, generator: np.random.Generator, kind: Exaggeration, strength: float
    ) -> tuple[np.ndarray, Recipe]:
        identity = int(generator.integers(self.settings.identities))
        expression = int(generator.integers(self.settings.expressions))
        vertices = self._regular(identity, expression)
        level = 0
        if Exaggeration.CURVATURE in kind:
            level = int(generator.integers(1, self.settings.levels))
            vertices = self._by_curvature(vertices, [EXPONENTS[level]])[0]
        if Exaggeration.PARTS not in kind:
            return vertices, Recipe(identity, expression, level, kind)
        parts = random_part_changes(generator, strength)
        hand = random_hand(vertices[self.template.annotation.landmarks], generator, min(strength, 1.0))
        recipe = Recipe(identity, expression, level, kind, parts, hand)
        return self._by_parts(vertices, parts, hand), recipe

    def _regular(self, identity: int, expression: int) -> np.ndarray:
        return regular_face(self.person(identity), self.actions[expression], self.head)

    def _by_curvature(self, vertices: np.ndarray, exponents: list[float] | tuple[float, ...]) -> np.ndarray:
        return exaggerate_curvature(vertices, self.template.faces, exponents, self.hold)

    def _by_parts(self, vertices: np.ndarray, parts: np.ndarray, hand: np.ndarray) -> np.ndarray:
        assert self.model is not None
        return self._in_place(exaggerate_parts(vertices, parts, hand, self.model), vertices)

    def _in_place(self, moved: np.ndarray, vertices: np.ndarray) -> np.ndarray:
        """An exaggerated shape in the size and place of the face that it was, so that it is one of its proportions."""
        scale, rotation, translation = similarity(moved[self.face], vertices[self.face])
        return untangle(scale * moved @ rotation.T + translation, self.template.gradients)

    def _flipped(self, vertices: np.ndarray) -> float:
        return float(flipped_triangles(vertices, self.template.gradients).mean())

    def _row(self, vertices: np.ndarray, recipe: Recipe) -> DatasetRow:
        vertices = self.template.cavities.tuck(vertices)
        identity = self.person(recipe.identity).identity
        exaggerated = recipe.kind != Exaggeration(0)
        measures = measure_attributes(vertices, self.template, identity.gender, identity.age, exaggerated)
        changes = [identity.changes.get(name, 0.0) for name in self.head.change_names]
        columns: dict[str, np.ndarray | int | float] = {
            "vertices": vertices.astype(np.float32),
            "identity": recipe.identity,
            "expression": recipe.expression,
            "level": recipe.level + 1,
            "kind": int(recipe.kind),
            "gender": identity.gender,
            "age": identity.age,
            "weight": identity.weight,
            "changes": np.array(changes, dtype=np.float32),
            "parts": recipe.parts.astype(np.float32),
            "hand": recipe.hand.astype(np.float32),
        }
        return DatasetRow(columns, measures, self._flipped(vertices))

    def _generator(self, purpose: DatasetSeed, number: int) -> np.random.Generator:
        return np.random.default_rng([self.settings.seed, purpose, number])
