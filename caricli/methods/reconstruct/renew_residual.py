"""What a face has beyond its latent, after its shape has changed."""

from dataclasses import replace

from caricli.methods.faces.encode_face import encode_face
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face


def renew_residual(face: Face, model: ShapeModel) -> Face:
    """The face with the latent that it has and the residual that its shape now needs.

    face: Face in the model's topology; without a latent it stays without, and is of no model. model: ShapeModel.
    """
    if face.latent is None:
        return replace(face, residual=None, model_id=None)
    return encode_face(replace(face, residual=None), model)
