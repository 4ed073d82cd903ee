"""Moved landmarks carried to the surface."""

import numpy as np

from caricli.data.move_parts import move_parts
from caricli.models.intrinsic.model import IntrinsicModel

ROUNDS = 5
"""Alternations of solve and projection, after which a face hardly changes."""

STRENGTH = 30.0
"""How strongly the landmarks pull at the surface, see ElasticAnchors.move."""

SHRINK = 2e-4
"""Weight of the latent's length against the features' distance in the projections."""


def exaggerate_parts(vertices: np.ndarray, changes: np.ndarray, hand: np.ndarray, model: IntrinsicModel) -> np.ndarray:
    """Change the parts of a face.

    Alternates the elastic solve in which the 81 landmarks make their moves with the projection of the result's
    deformation features onto the model, which turns stretched skin into the shape of a face; what the model could
    not express of the given face stays on it.

    vertices: (V, 3) metres. changes: (len(move_parts.NAMES),). hand: (81, 3) metres, moves added to those of the parts.
    model: of plausible faces with 81 landmarks.
    Returns (V, 3); the skull as a whole stays where it was.
    """
    gradients = model.template.gradients
    landmarks = model.template.annotation.landmarks
    target = move_parts(vertices[landmarks], changes) + hand
    features = gradients.features(vertices)
    latent = model.features_to_latent(features, SHRINK)
    rest = features - model.features(latent)
    for _ in range(ROUNDS):
        shape = gradients.vertices(model.features(latent) + rest)
        moves = target - shape[landmarks]
        shape += model.template.anchors.move(landmarks, moves, STRENGTH)
        latent = model.features_to_latent(gradients.features(shape), SHRINK)
    return shape
