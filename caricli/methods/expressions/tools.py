"""What expressions of caricatures are made with."""

from dataclasses import dataclass, replace
from functools import cached_property

from caricli.methods.rig.expression_templates import ExpressionTemplates, combine_templates
from caricli.models.landmark_map.model import LandmarkMap
from caricli.models.morphable.model import MorphableModel
from caricli.models.shape_model import ShapeModel
from caricli.structures import SeenPeople


@dataclass(frozen=True, eq=False)
class ExpressionTools:
    """Everything that expressions are made of but the caricature, all of one mesh.

    actions: ExpressionTemplates that expressions are combined of.
    expressions: weights of actions by name, the neutral expression first.
    morphable: MorphableModel of normal faces.
    landmark_map: LandmarkMap between normal faces and caricatures.
    latent: ShapeModel that can follow landmarks in its latent, or None.
    """

    actions: ExpressionTemplates
    expressions: dict[str, dict[str, float]]
    morphable: MorphableModel
    landmark_map: LandmarkMap
    latent: ShapeModel | None = None

    @property
    def seen(self) -> dict[str, SeenPeople | None]:
        """By model, whom it was trained with."""
        models = [self.morphable, *([self.latent] if self.latent else [])]
        return {model.kind: model.seen for model in models} | {"landmark map": self.landmark_map.seen}

    @cached_property
    def templates(self) -> ExpressionTemplates:
        """Of the expressions, the neutral one first."""
        return combine_templates(self.actions, self.expressions)

    @cached_property
    def acting(self) -> ExpressionTemplates:
        """The templates without the neutral one; what they find out of themselves is kept for every rig."""
        names, deltas, weights = self.templates.names, self.templates.deltas, tuple(self.expressions.values())
        return replace(self.templates, names=names[1:], deltas=deltas[1:], weights=weights[1:])
