"""Faces between two faces, along the straight line of their latents."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from caricli.methods.faces.encode_face import EncodedFace, decode_face, encode_face, require_encoded
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face


def interpolate_faces(first: EncodedFace, second: EncodedFace, model: ShapeModel, steps: int) -> Iterator[EncodedFace]:
    """Go from one face to another in equal steps of the latent, and of what it leaves over.

    The ends are the given faces exactly; in between, triangles that flip on the way are turned back, and cavities kept
    behind the skin. No picture shows what is between two faces, so none has a camera. What they wear turns from one
    into the other where both wear pictures of one layout and size; else a step wears what the nearer end does, or the
    one that wears pictures or hair. Teeth grow and shrink on the way.

    first, second: EncodedFace of the model. model: ShapeModel. steps: number of faces, both ends included, at least 2.
    Yields an EncodedFace for every step. Raises InputError for faces of another model.
    """
    for end in (first, second):
        require_encoded(end, model)
    yield _unseen(first)
    for weight in np.linspace(0, 1, steps)[1:-1]:
        latent = (1 - weight) * first.latent + weight * second.latent
        residual = (1 - weight) * first.residual + weight * second.residual
        shift = (1 - weight) * first.shift + weight * second.shift
        worn = _worn(first, second, float(weight))
        blend = replace(worn, latent=latent, residual=residual, model_id=model.model_id)
        vertices = model.template.mended(decode_face(blend, model, shift).vertices)
        yield encode_face(replace(blend, residual=None).with_vertices(vertices), model)
    yield _unseen(second)


def _worn(first: Face, second: Face, weight: float) -> Face:
    """A Face with what a step wears, in the shape of either end."""
    dressed = [face for face in (first, second) if face.pictures or face.hair is not None]
    nearer = dressed[0] if len(dressed) == 1 else second if weight > 0.5 else first
    pictures = nearer.pictures
    if first.pictures and second.pictures and first.mesh.same_layout(second.mesh):
        pictures = first.pictures.mixed(second.pictures, weight)
    return Face(
        nearer.mesh,
        pictures=pictures,
        materials=nearer.materials,
        hair=nearer.hair,
        teeth=_teeth(first.teeth, second.teeth, weight),
    )


def _teeth(first: np.ndarray | None, second: np.ndarray | None, weight: float) -> np.ndarray | None:
    """How far teeth (2,) are seen between two faces; as on the one whose picture says it, where only one does."""
    if first is None or second is None:
        return second if first is None else first
    return (1 - weight) * first + weight * second


def _unseen(face: EncodedFace) -> EncodedFace:
    """The face without camera and landmarks."""
    if face.camera is None and face.landmarks is None:
        return face
    return replace(face, camera=None, landmarks=None)
