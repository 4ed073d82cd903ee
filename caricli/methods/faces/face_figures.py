"""What reports say of a face."""

from typing import Any

from caricli.data.attributes import measure_attributes
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.faces.encode_face import EncodedFace
from caricli.models.shape_model import ShapeModel


def soundness(face: EncodedFace, model: ShapeModel) -> dict[str, float]:
    """How plausible and how whole a face is: ``prior_rms``, and the share ``flipped`` of its triangles."""
    flipped = float(flipped_triangles(face.vertices, model.template.gradients).mean())
    return {"prior_rms": face.prior_rms, "flipped": flipped}


def face_figures(face: EncodedFace, model: ShapeModel) -> dict[str, Any]:
    """The same, and ``attributes``, a dict of names to measures, where the template has the landmarks for them."""
    template = model.template
    if not template.annotation.has_extra:
        return soundness(face, model)
    return soundness(face, model) | {"attributes": measure_attributes(face.vertices, template)}
