"""A regular face made a caricature: along the direction of all caricatures, or away from the mean face."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from caricli.errors import InputError
from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.repair.untangle import untangle
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.edit.edit_semantic import SemanticEdit, edit_semantic, label_index
from caricli.methods.edit.settings import MODES
from caricli.methods.faces.encode_face import EncodedFace, encode_face, require_encoded
from caricli.methods.faces.face_figures import face_figures
from caricli.methods.faces.nearest_identity import likeness
from caricli.models.intrinsic.model import feature_weights
from caricli.models.shape_model import ShapeModel
from caricli.structures import Directions
from caricli.template.annotation import DELICATE
from caricli.template.template import Template

LABEL = "Caricature"
"""The label whose direction leads from regular faces to caricatures."""

OWN = 0.75
"""Features that a strength of 1 adds, as a share of the face's own: shows about as clearly as 1 along the direction."""

ROUNDS = 12
"""Edges that features are smoothed over: folds, which are smaller, would only fold over."""

EDGE = 4
"""Edges over which the exaggeration fades out towards eyes, mouth and neck."""

STEP = 0.25
"""Strength of one step: small enough that triangles that turn over can be turned back."""


@dataclass(frozen=True)
class Exaggeration:
    """How much of a caricature a face is.

    caricature: standard deviations along the direction of caricatures, or None where there is none.
    distance: root mean square distance of its features from the template's, weighted by area.
    """

    caricature: float | None
    distance: float


def caricaturize_face(
    face: EncodedFace,
    model: ShapeModel,
    strength: float,
    mode: str = "direction",
    directions: Directions | None = None,
) -> EncodedFace:
    """Exaggerate a face by the method of a name.

    "direction" goes ``strength`` standard deviations from regular faces towards caricatures (deformable paper 5.4), and
    what the latent cannot express stays. "own" enlarges what sets the face apart from the mean head, as caricaturists
    do: to its deformation-gradient features against the template, which the mean head has none of, ``OWN * strength``
    times the same features, smoothed over ``ROUNDS`` edges, are added; eyes and mouth keep the expression, and the neck
    its width, of which that of a drawing would soon have none. It grows by steps of ``STEP``, each of which is taken
    back where it turns triangles over, so that more strength never exaggerates less. Size and place stay.

    face: EncodedFace of the model. model: ShapeModel. strength: 0 changes nothing, 1 shows clearly, 2 is strong.
    mode: of MODES. directions: Directions of the model with the label "Caricature", for "direction".
    Returns EncodedFace. Raises InputError.
    """
    require_encoded(face, model)
    if mode not in MODES:
        raise InputError(f"expected a mode of {', '.join(MODES)}, found {mode!r}")
    if not 0 <= strength < np.inf:
        raise InputError(f"expected a strength of 0 or more, found {strength:g}")
    if mode == "direction":
        if directions is None:
            raise InputError("expected directions of the model, those of load_directions, for 'direction', found none")
        return edit_semantic(face, model, SemanticEdit(directions, {LABEL: strength}))
    if not strength:
        return face
    template = model.template
    grown = template.cavities.tuck(_grown(_aligned(face.vertices, template), strength, template))
    place = template.region("face")
    scale, rotation, translation = similarity(grown[place], face.vertices[place])
    return encode_face(face.without_latent().with_vertices(scale * grown @ rotation.T + translation), model)


def exaggeration(face: EncodedFace, model: ShapeModel, directions: Directions | None = None) -> Exaggeration:
    """Measure how much of a caricature a face is.

    face: EncodedFace of the model. model: ShapeModel. directions: Directions of the model, or None.
    """
    features = model.template.gradients.features(_aligned(face.vertices, model.template))
    distance = float(np.sqrt(feature_weights(model.template) @ (features**2).sum(1)))
    if directions is None or LABEL not in directions.names:
        return Exaggeration(None, distance)
    normal = directions.normals[label_index(directions, LABEL)]
    return Exaggeration(float(normal @ model.prior.whiten(face.latent)), distance)


def caricature_figures(
    before: EncodedFace, after: EncodedFace, model: ShapeModel, directions: Directions | None = None
) -> dict[str, Any]:
    """What the JSON says of a caricature: whether it is still like its ``identity``, and both faces; what only
    directions tell is absent without them.

    before, after: EncodedFace of the model. model: ShapeModel. directions: Directions of the model, or None.
    """
    like = None if directions is None else likeness(before, after, model, directions.people)
    figures: dict[str, Any] = {} if like is None else {"identity": asdict(like)}
    for when, face in (("before", before), ("after", after)):
        measured = asdict(exaggeration(face, model, directions)).items()
        there = {name: value for name, value in measured if value is not None}
        figures[when] = {"exaggeration": there} | face_figures(face, model)
    return figures


def _grown(vertices: np.ndarray, strength: float, template: Template) -> np.ndarray:
    """Vertices (V, 3) in the template's pose with more of their own features, untorn."""
    gradients = template.gradients
    features = gradients.features(vertices)
    whole = OWN * _broad(features, template)
    grown = vertices
    rest = strength % STEP
    for amount in [*[STEP] * int(strength / STEP), *([rest] if rest else [])]:
        more = gradients.vertices_like(features + amount * whole, grown)
        grown = untangle(more, gradients, before=grown)
        features = gradients.features(grown)
    return grown


def _broad(features: np.ndarray, template: Template) -> np.ndarray:
    """Features (V, 9) without their details, fading out towards eyes, mouth and neck."""
    _, neighbours = vertex_neighbours(template.faces, len(template.vertices))
    mean = 0.5 * (sp.identity(len(template.vertices)) + neighbours)
    free = 1.0 - template.mask(*DELICATE, "neck")
    for _ in range(EDGE):
        free = mean @ free
    for _ in range(ROUNDS):
        features = mean @ features
    return free[:, None] * features


def _aligned(vertices: np.ndarray, template: Template) -> np.ndarray:
    """Vertices in the template's pose and size, so that neither is taken for what is special about a face."""
    place = template.region("face")
    scale, rotation, translation = similarity(vertices[place], template.vertices[place])
    return scale * vertices @ rotation.T + translation
