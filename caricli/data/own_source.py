"""The meshes of a generated dataset in which people's own features are exaggerated."""

from dataclasses import replace

import numpy as np

from caricli.data.build_settings import DRAW, Exaggeration, OwnSettings
from caricli.data.exaggerate_own import UsualFace, exaggerate_own, random_whim
from caricli.data.mesh_source import STRANGERS, DatasetRow, MeshSource, Prior, Recipe
from caricli.data.move_parts import random_hand, random_part_changes
from caricli.seeds import DatasetSeed

Usual = tuple[np.ndarray, np.ndarray]
"""Mean and deviation of a UsualFace."""


class OwnSource(MeshSource):
    """Makes meshes by their numbers; what all of them need is made once."""

    def __init__(self, settings: OwnSettings, prior: Prior | None = None, usual: Usual | None = None) -> None:
        """prior, usual: where anything is exaggerated."""
        super().__init__(settings, prior)
        self.own_settings = settings
        self.usual = UsualFace(self.template, *usual) if usual else None
        self._neutral: dict[int, np.ndarray] = {}

    def neutral_features(self, number: int) -> np.ndarray:
        """(V, 9) features of the neutral face of someone who is not in the dataset."""
        return self.template.gradients.features(self._regular(STRANGERS + number, 0))

    def draw(self, number: int) -> DatasetRow:
        """One random mesh; redrawn with milder whims while too many triangles flip."""
        generator = self._generator(DatasetSeed.DRAW, number)
        kind = self._random_kind(generator)
        strength = generator.uniform(*self.own_settings.strength)
        mildness = 1.0
        for _ in range(DRAW.tries):
            identity = int(generator.integers(self.settings.identities))
            expression = int(generator.integers(self.settings.expressions))
            recipe = Recipe(identity, expression, kind=kind)
            vertices = self._regular(identity, expression)
            if Exaggeration.OWN in kind:
                vertices = self._by_own_features(vertices, self._at_rest(identity), generator, mildness)
            if Exaggeration.PARTS in kind:
                parts = random_part_changes(generator, mildness * strength)
                landmarks = vertices[self.template.annotation.landmarks]
                hand = random_hand(landmarks, generator, min(mildness * strength, 1.0))
                recipe = replace(recipe, parts=parts, hand=hand)
                vertices = self._by_parts(vertices, parts, hand)
            if self._flipped(vertices) <= DRAW.max_flipped:
                break
            mildness *= DRAW.milder
        return self._row(vertices, recipe)

    def _random_kind(self, generator: np.random.Generator) -> Exaggeration:
        if self.settings.levels == 1 or generator.random() < self.own_settings.regular:
            return Exaggeration(0)
        with_parts = generator.random() < self.own_settings.parts
        return Exaggeration.OWN | Exaggeration.PARTS if with_parts else Exaggeration.OWN

    def _at_rest(self, identity: int) -> np.ndarray:
        """(V, 3) the neutral face of a person, which is asked for again."""
        if identity not in self._neutral:
            self._neutral[identity] = self._regular(identity, 0)
        return self._neutral[identity]

    def _by_own_features(
        self, vertices: np.ndarray, neutral: np.ndarray, generator: np.random.Generator, mildness: float
    ) -> np.ndarray:
        assert self.usual is not None
        whim = random_whim(self.template.vertices, self.template.height, generator, mildness)
        return self._in_place(exaggerate_own(vertices, neutral, whim, self.usual), vertices)
