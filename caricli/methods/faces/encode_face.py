"""A mesh in the terms of a shape model, and back: what the latent cannot express is kept beside it."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class EncodedFace:
    """A face and what a model says of it.

    vertices (V, 3) metres; latent (D,); residual (V, 9) deformation-gradient features beyond those of the latent;
    shift (3,) metres, from the centroid of the latent's own shape to the face's; millimetres and percent of the head's
    height, the shape error of the latent alone; prior_rms.
    """

    vertices: np.ndarray
    latent: np.ndarray
    residual: np.ndarray
    shift: np.ndarray
    millimetres: float
    percent: float
    prior_rms: float


_SAME = 1e-6


def encode_face(vertices, model, latent=None, residual=None):
    """Find the latent of a face and what it leaves over.

    The face keeps its likeness: ``decode_face`` of all three gives the very vertices back.

    vertices: (V, 3) metres, of the model's topology. model: ShapeModel. latent: (D,) where it is known already;
    residual: (V, 9) that was kept with it, taken as it is where both give the vertices to a micrometre.
    Returns EncodedFace.
    """
    vertices = np.asarray(vertices, dtype=np.float64)
    latent = model.encode(vertices) if latent is None else np.asarray(latent, dtype=np.float64)
    own = model.decode(latent)
    shift = vertices.mean(0) - own.mean(0)
    # Features of no shape do not come back from their shape: only as they were given do steps to and fro cancel.
    kept = residual is not None and np.abs(decode_face(latent, residual, model, shift) - vertices).max() < _SAME
    if not kept:
        residual = model.template.gradients.features(vertices) - _latent_features(model, latent, own)
    error = float(np.linalg.norm(own - vertices, axis=-1).mean())
    figures = 1000 * error, 100 * error / model.template.height, float(model.prior.rms(latent))
    return EncodedFace(vertices, latent, residual, shift, *figures)


def decode_face(latent, residual, model, shift=0.0):
    """The inverse of ``encode_face``: features of the latent plus the residual, solved for the shape.

    latent: (D,). residual: (V, 9). model: ShapeModel; an IntrinsicModel's ``decode(latent, residual)`` is the same.
    shift: (3,) metres, or none.
    Returns (V, 3).
    """
    own = model.decode(latent)
    features = _latent_features(model, latent, own) + residual
    return model.template.gradients.vertices(features) + own.mean(0) + shift


def _latent_features(model, latent, own):
    # What an intrinsic latent stands for are features that no shape has exactly, its own shape's among them.
    return model.features(latent) if model.kind == "intrinsic" else model.template.gradients.features(own)
