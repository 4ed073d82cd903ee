"""A mesh in the terms of a shape model, and back: what the latent cannot express is kept beside it."""

from dataclasses import dataclass, field, fields, replace

import numpy as np

from caricli.errors import InputError
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face

_MOVED = 0.08
"""Of the template's height: how far the mean vertex of a face may be from the template's; of people it is by 0.06."""

_SIZES = (0.7, 1.4)
"""Of the template's height: faces that drawings and people have are between 0.85 and 1.1 times as high."""

_SAME = 1e-6
"""Metres: a residual whose shape is as near as this is the one that was kept with the latent."""


@dataclass(frozen=True, eq=False)
class EncodedFace(Face):
    """A Face with all that a model says of it: ``latent``, ``residual`` and ``model_id`` are there.

    shift: (C, 3) metres, from the centroids of the components of the latent's own shape to those of the face.
    millimetres, percent: shape error of the latent alone, the latter of the template's height.
    prior_rms: root mean square of the whitened latent, about 1 for a typical face.
    """

    latent: np.ndarray = field(kw_only=True)
    residual: np.ndarray = field(kw_only=True)
    shift: np.ndarray = field(kw_only=True)
    millimetres: float = field(kw_only=True)
    percent: float = field(kw_only=True)
    prior_rms: float = field(kw_only=True)


def encode_face(face: Face, model: ShapeModel) -> EncodedFace:
    """Find the latent of a face and what it leaves over.

    The face keeps its likeness: ``decode_face`` gives the very vertices back. All else of it stays.

    face: Face of the model's topology. A latent that is the model's is kept, and with it a residual where both give the
    vertices to a micrometre, as they are or mended (``Template.mended``); else they are found.
    model: ShapeModel.
    Returns EncodedFace.
    """
    vertices = np.asarray(face.vertices, dtype=np.float64)
    kept = face.latent is not None and face.model_id == model.model_id
    place = np.zeros(3) if kept else _place(vertices, model)
    latent = np.asarray(face.latent, dtype=np.float64) if kept else model.encode(vertices - place)
    own = model.decode(latent)
    shift = model.template.gradients.components.averages @ (vertices - own)
    residual = face.residual if kept else None
    mesh = face.mesh.with_vertices(vertices)
    coded = replace(_plain(face), mesh=mesh, latent=latent, residual=residual, model_id=model.model_id)
    # Features of no shape do not come back from their shape: only as they were given do steps to and fro cancel.
    given = None if residual is None else _given_shift(coded, model, shift)
    if given is None:
        residual = model.template.gradients.features(vertices) - _own_features(model, latent, own)
    else:
        shift = given
    error = float(np.linalg.norm(own + place - vertices, axis=-1).mean())
    return EncodedFace(
        **vars(coded) | {"residual": residual},
        shift=shift,
        millimetres=1000 * error,
        percent=100 * error / model.template.height,
        prior_rms=float(model.prior.rms(latent)),
    )


def _place(vertices: np.ndarray, model: ShapeModel) -> np.ndarray:
    """(3,) metres, how far a head (V, 3) was moved as a whole, as another program may have done: it is no shape.

    A mean that is far from the template's may also be that of a likely shape: what is no less likely counts as moved.
    """
    away = (vertices - model.template.vertices).mean(0)
    if np.linalg.norm(away) <= _MOVED * model.template.height:
        return np.zeros(3)
    there, back = (model.prior.rms(model.encode(vertices - place)) for place in (0, away))
    return away if back <= there * (1 + _SAME) else np.zeros(3)


def size_note(face: Face, model: ShapeModel) -> str | None:
    """A line about a Face of another size than the model's, which is read as another shape; None for the usual ones."""
    height = model.template.height
    times = face.mesh.height / height
    if _SIZES[0] <= times <= _SIZES[1]:
        return None
    return (
        f"{times:.2g} times as high as heads of the model, which is read as a shape, and edits come out otherwise: "
        f"make it about {height:.2g} m high first"
    )


def require_encoded(face: Face, model: ShapeModel) -> None:
    """Raise InputError for a Face that ``encode_face`` did not give, or that it gave for another model."""
    if not isinstance(face, EncodedFace):
        raise InputError("expected a face that encode_face gave for this model, found one that was not encoded")
    if face.model_id != model.model_id:
        raise InputError("expected a face that encode_face gave for this model, found one of another model")


def decode_face(face: Face, model: ShapeModel, shift: np.ndarray | float = 0.0) -> Face:
    """The inverse of ``encode_face``: features of the latent plus the residual, solved for the shape.

    face: Face with a latent of the model, and a residual where there is one; its own shape does not count.
    model: ShapeModel; an IntrinsicModel's ``decode(latent, residual)`` is the same.
    shift: (C, 3) metres, of the components' centroids from those of the latent's own shape.
    Returns the Face in that shape, with all else that it has.
    """
    assert face.latent is not None
    own = model.decode(face.latent)
    features = _own_features(model, face.latent, own) + (0.0 if face.residual is None else face.residual)
    gradients = model.template.gradients
    means = gradients.components.averages @ own + shift
    return _plain(face).with_vertices(gradients.components.place(gradients.vertices(features), means))


def _plain(face: Face) -> Face:
    """The same without what encoding found."""
    return Face(**{part.name: getattr(face, part.name) for part in fields(Face)})


def _given_shift(face: Face, model: ShapeModel, shift: np.ndarray) -> np.ndarray | None:
    """The shift (C, 3) by which latent and residual give the vertices, as they are or mended; None where they do not.

    shift: that of the vertices, which mending may have moved.
    """
    decoded = decode_face(face, model, shift).vertices
    if _same(decoded, face.vertices):
        return shift
    mended = model.template.mended(decoded)
    components = model.template.gradients.components
    means = components.averages @ face.vertices
    if not _same(components.place(mended, means), face.vertices):
        return None
    return shift + means - components.averages @ mended


def _same(vertices: np.ndarray, others: np.ndarray) -> bool:
    return bool(np.abs(vertices - others).max() < _SAME)


def _own_features(model: ShapeModel, latent: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Features (V, 9) that a latent stands for; own: (V, 3), its shape."""
    # What an intrinsic latent stands for are features that no shape has exactly, its own shape's among them.
    return model.features(latent) if isinstance(model, IntrinsicModel) else model.template.gradients.features(own)
