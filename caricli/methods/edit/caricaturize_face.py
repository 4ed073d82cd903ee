"""A regular face made a caricature: along the direction of all caricatures, or away from the mean face."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from caricli.geometry.similarity import similarity
from caricli.geometry.untangle import untangle
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.edit.edit_semantic import edit_semantic, label_index
from caricli.methods.faces.encode_face import encode_face
from caricli.models.intrinsic.model import feature_weights

LABEL = "Caricature"
OWN = 0.75
ROUNDS, EDGE, STEP = 12, 4, 0.25
HELD = ("eyes_left", "eyes_right", "eye_socket_left", "eye_socket_right", "mouth", "inner_mouth")


@dataclass(frozen=True)
class Exaggeration:
    """How much of a caricature a face is.

    caricature: standard deviations along the direction of caricatures, or None where there is none; distance: root mean
    square distance of its features from the template's, weighted by area.
    """

    caricature: float | None
    distance: float


def caricaturize_face(face, model, strength, mode="direction", directions=None):
    """Exaggerate a face by the method of a name.

    "direction" goes ``strength`` standard deviations from regular faces towards caricatures (deformable paper 5.4), and
    what the latent cannot express stays. "own" enlarges what sets the face apart from the mean head, as caricaturists
    do: to its deformation-gradient features against the template, which the mean head has none of, ``OWN * strength``
    times the same features, smoothed over ``ROUNDS`` edges, are added; folds would only fold over, and eyes and mouth
    keep the expression. It grows by steps of ``STEP``, each of which is taken back where it turns triangles over, so
    that more strength never exaggerates less. Size and place stay.

    face: EncodedFace of the model. model: ShapeModel. mode: "direction" or "own". directions: Directions of the model
    with the label "Caricature", for "direction".
    Returns EncodedFace. Raises InputError.
    """
    if mode == "direction":
        return edit_semantic(face, model, directions, {LABEL: strength})
    if not strength:
        return face
    template, gradients = model.template, model.template.gradients
    grown = _aligned(face.vertices, template)
    features = gradients.features(grown)
    whole = OWN * _broad(features, template)
    for amount in (*[STEP] * int(strength / STEP), strength % STEP):
        before, features = grown, features + amount * whole
        grown = untangle(gradients.vertices(features), gradients, before=before)
        features = gradients.features(grown)
    grown = template.cavities.tuck(grown)
    place = template.region("face")
    scale, rotation, translation = similarity(grown[place], face.vertices[place])
    return encode_face(scale * grown @ rotation.T + translation, model)


def exaggeration(face, model, directions=None):
    """Measure an EncodedFace. directions: Directions of the model, or None. Returns Exaggeration."""
    features = model.template.gradients.features(_aligned(face.vertices, model.template))
    distance = float(np.sqrt(feature_weights(model.template) @ (features**2).sum(1)))
    if directions is None or LABEL not in directions.names:
        return Exaggeration(None, distance)
    normal = directions.normals[label_index(directions, LABEL)]
    return Exaggeration(float(normal @ model.prior.whiten(face.latent)), distance)


def _broad(features, template):
    """Features (V, 9) without their details, fading out towards eyes and mouth."""
    _, neighbours = vertex_neighbours(template.faces, len(template.vertices))
    mean = 0.5 * (sp.identity(len(template.vertices)) + neighbours)
    free = 1.0 - template.mask(*HELD)
    for _ in range(EDGE):
        free = mean @ free
    for _ in range(ROUNDS):
        features = mean @ features
    return free[:, None] * features


def _aligned(vertices, template):
    """Vertices in the template's pose and size, so that neither is taken for what is special about a face."""
    place = template.region("face")
    scale, rotation, translation = similarity(vertices[place], template.vertices[place])
    return scale * vertices @ rotation.T + translation
