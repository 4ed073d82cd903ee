"""What operations work with; the store loads each when it is first asked for."""

from typing import Protocol

from caricli.methods.faces.encode_landmarks import LandmarkEncoder
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.sketch.reconstruct_sketch import SketchReconstruction
from caricli.models.gesture.model import GestureModel
from caricli.models.shape_model import ShapeModel
from caricli.models.sketch.model import SketchModel
from caricli.structures import Directions


class Tools(Protocol):
    """Loaded once and kept factored.

    model: ShapeModel that all faces are encoded in. encoder: LandmarkEncoder of it. network: SketchModel, and basis the
    ShapeModel whose latents it tells. reconstruction: SketchReconstruction of the model. directions: Directions of the
    model. templates: ExpressionTemplates of ARKit's actions. gestures: GestureModel.
    """

    @property
    def model(self) -> ShapeModel:
        """The shape model."""

    @property
    def encoder(self) -> LandmarkEncoder:
        """Faces of landmarks."""

    @property
    def network(self) -> SketchModel:
        """Faces of sketches."""

    @property
    def basis(self) -> ShapeModel:
        """The model whose latents the network tells."""

    @property
    def reconstruction(self) -> SketchReconstruction:
        """Faces that follow lines."""

    @property
    def directions(self) -> Directions:
        """Labels."""

    @property
    def templates(self) -> ExpressionTemplates:
        """Expressions."""

    @property
    def gestures(self) -> GestureModel:
        """What strokes on the head mean."""
