"""The meshes of a generated dataset in which people's own features are exaggerated."""

import numpy as np

from caricli.data.build_settings import DRAW, Exaggeration, OwnSettings
from caricli.data.exaggerate_own import UsualFace, exaggerate_own, random_whim
from caricli.data.mesh_source import STRANGERS, DatasetRow, MeshSource, Recipe
from caricli.geometry.similarity import similarity
from caricli.geometry.untangle import untangle
from caricli.seeds import DatasetSeed

Usual = tuple[np.ndarray, np.ndarray]
"""Mean and deviation of a UsualFace."""


class OwnSource(MeshSource):
    """Makes meshes by their numbers; what all of them need is made once."""

    def __init__(self, settings: OwnSettings, usual: Usual | None = None) -> None:
        """usual: where own features are exaggerated."""
        super().__init__(settings)
        self.regular = settings.regular
        self.usual = UsualFace(self.template, *usual) if usual else None
        self._neutral: dict[int, np.ndarray] = {}

    def neutral_features(self, number: int) -> np.ndarray:
        """(V, 9) features of the neutral face of someone who is not in the dataset."""
        return self.template.gradients.features(self._regular(STRANGERS + number, 0))

    def draw(self, number: int) -> DatasetRow:
        """One random mesh; redrawn with milder whims while too many triangles flip."""
        generator = self._generator(DatasetSeed.DRAW, number)
        regular = self.settings.levels == 1 or generator.random() < self.regular
        kind = Exaggeration(0) if regular else Exaggeration.OWN
        mildness = 1.0
        for _ in range(DRAW.tries):
            recipe = Recipe(
                int(generator.integers(self.settings.identities)),
                int(generator.integers(self.settings.expressions)),
                kind=kind,
            )
            vertices = self._regular(recipe.identity, recipe.expression)
            if regular:
                break
            vertices = self._by_own_features(vertices, recipe, generator, mildness)
            if self._flipped(vertices) <= DRAW.max_flipped:
                break
            mildness *= DRAW.milder
        return self._row(vertices, recipe)

    def _by_own_features(
        self, vertices: np.ndarray, recipe: Recipe, generator: np.random.Generator, mildness: float
    ) -> np.ndarray:
        assert self.usual is not None
        if recipe.identity not in self._neutral:
            self._neutral[recipe.identity] = self._regular(recipe.identity, 0)
        neutral = self._neutral[recipe.identity]
        whim = random_whim(self.template.vertices, self.template.height, generator, mildness)
        moved = exaggerate_own(vertices, neutral, whim, self.usual)
        # Size and place of the face are kept, so that the exaggeration is of its proportions.
        scale, rotation, translation = similarity(moved[self.face], vertices[self.face])
        return untangle(scale * moved @ rotation.T + translation, self.template.gradients)
