"""What makes faces of a shape model from landmarks."""

from caricli.methods.faces.encode_landmarks import LandmarkEncoder, landmark_encoder
from caricli.models.shape_model import ShapeModel
from caricli.store.models import load_model


def elastic_encoder(model: ShapeModel) -> LandmarkEncoder:
    """The LandmarkEncoder of a model: by the bundled elastic model, where that of the same mesh is none itself."""
    return landmark_encoder(model, model if model.kind == "intrinsic" else load_model())
