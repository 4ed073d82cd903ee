"""Moved landmarks carried to the surface."""

from caricli.data.move_parts import move_parts

ROUNDS = 5
STRENGTH = 30.0
SHRINK = 2e-4


def exaggerate_parts(vertices, changes, hand, model, rounds=ROUNDS):
    """Change the parts of a face.

    Alternates the elastic solve in which the 81 landmarks make their moves with the projection of the result's
    deformation features onto the model, which turns stretched skin into the shape of a face; what the model could
    not express of the given face stays on it.

    vertices: (V, 3). changes: (len(move_parts.NAMES),). hand: (81, 3) moves added to those of the parts. model:
    IntrinsicModel of plausible faces with 81 landmarks.
    Returns (V, 3); the skull as a whole stays where it was.
    """
    gradients, landmarks, anchors = model.template.gradients, model.template.annotation.landmarks, model.anchors
    target = move_parts(vertices[landmarks], changes) + hand
    features = gradients.features(vertices)
    latent = model.features_to_latent(features, SHRINK)
    rest = features - model.features(latent)
    for _ in range(rounds):
        shape = gradients.vertices(model.features(latent) + rest)
        moves = target - shape[landmarks]
        shape += anchors.move(landmarks, moves, STRENGTH)
        latent = model.features_to_latent(gradients.features(shape), SHRINK)
    return shape
