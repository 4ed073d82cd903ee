"""Expressions of a caricature from those of a normal face (expressions paper, section 3.2)."""

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.deformation_transfer import DeformationTransfer, triangle_maps
from caricli.geometry.elastic_anchors import ElasticAnchors
from caricli.geometry.similarity import similarity
from caricli.methods.edit.map_landmarks import map_landmarks
from caricli.methods.expressions.optimise_blendshapes import (
    UNMOVED,
    BlendshapeWeights,
    displacement_masks,
    optimise_blendshapes,
)
from caricli.methods.reconstruct.fit_landmarks import LandmarkFit, LatentSettings, landmark_vertices
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.rig.expression_templates import STARTS, start_delta
from caricli.methods.rig.keep_contacts import Contacts
from caricli.models.landmark_map.model import COUNT

METHODS = ("full", "initial", "transfer")
EXAGGERATION, FARTHEST, STRENGTH = 1.08, 1.25, 0.1
"""How much more than the normal face a caricature does, and how far a landmark may go at most, of the way of the normal
face's; how much landmarks pull, against the surface."""


@dataclass(frozen=True, eq=False)
class Blendshapes:
    """shapes (K, V, 3) of the caricature; normal (K, V, 3) of the normal face, and normal_given (V, 3) with its own
    expression; fit, LandmarkFit of the normal face; landmarks (K, 68, 2) of the caricature in pixels, or None."""

    shapes: np.ndarray
    normal: np.ndarray
    normal_given: np.ndarray
    fit: LandmarkFit
    landmarks: np.ndarray | None


# The matrices are small: threads that wait for each other cost more than they bring.
@threadpool_limits.wrap(limits=1)
def build_blendshapes(
    vertices, pose, templates, morphable, landmark_map, method="full", weights=None, model=None, contacts=True
):
    """Build the expressions of a caricature that shows one of its own.

    The landmarks of the caricature, as its vertices show them, are mapped to those of a normal face, and the morphable
    model is fitted to these (equation 2). With each expression in the place of its own (equation 3) the landmarks move,
    are mapped back, and the caricature is reconstructed from them (``_reconstructed``), its pose and everything that
    landmarks do not show kept. "initial" stops there; "full" optimises the displacements (equations 4 to 11) and lets
    lids and lips meet; "transfer" instead transfers the deformations of the normal face (Sumner and Popovic 2004).

    vertices: (V, 3) metres, S(e_x). pose: Camera of its picture. templates: ExpressionTemplates, of the models' topology.
    morphable: MorphableModel. landmark_map: LandmarkMap. method: of METHODS. weights: BlendshapeWeights. model:
    ShapeModel whose latent is fitted to the landmarks, or None for deformation gradients. contacts: whether "full"
    keeps them. Returns Blendshapes. Raises InputError, NumericsError.
    """
    template, faces = morphable.template, morphable.template.faces
    scale, *_ = similarity(template.vertices, vertices)
    vertices, pose = vertices / scale, replace(pose, scale=pose.scale * scale)
    anchors = landmark_vertices(vertices, pose.rotation, template, COUNT)
    fit = fit_morphable(map_landmarks(pose.project(vertices[anchors]), landmark_map, "normal"), morphable)
    who, _ = morphable.parts(fit.latent)
    given = morphable.decode(fit.latent)
    normal = morphable.mean + np.tensordot(who, morphable.identity, 1) + templates.deltas
    held = displacement_masks(templates.deltas).max(0) < UNMOVED
    if method == "transfer":
        shapes = _transferred(vertices, given, normal, held, faces)
        return Blendshapes(scale * shapes, normal, given, fit, None)
    marks = _marks(vertices[anchors], pose, given, normal, fit, landmark_map)
    shapes = _reconstructed(vertices, pose, anchors, marks, given, normal, template, model)
    if method == "full":
        parts = _from_neutral(shapes, vertices), _from_neutral(normal, given)
        # What the fit makes of a neutral face is noise; an expression worth its name moves as far as others do.
        usual = np.median(np.linalg.norm(parts[1], axis=2).max(1))
        least = np.where(np.arange(len(shapes)) == 0, usual, 0.0)
        found = optimise_blendshapes(*parts, vertices, faces, weights or BlendshapeWeights(), least)
        neutral, found[0] = vertices + found[0], 0
        if contacts:
            kept = Contacts(templates, neutral, DeformationTransfer(neutral, faces, held))
            for k in sorted(range(len(found)), key=lambda k: templates.names[k] in STARTS):
                if templates.motions[k] is not None:
                    start = start_delta(templates.names, found, k)
                    found[k] = kept.keep(k, found[k] + start) - start
        shapes = neutral + found
    return Blendshapes(scale * shapes, normal, given, fit, marks)


def _marks(own, pose, given, normal, fit, landmark_map):
    """(K, 68, 2) landmarks of the caricature with every expression.

    Mapped differences are added to its own landmarks, so that what the map loses stays; and no landmark goes farther
    than ``FARTHEST`` times as far as on the normal face, because the map exaggerates moves as it exaggerates faces.
    own: (68, 3) vertices of the caricature. fit: LandmarkFit of the normal face.
    """
    ids = fit.anchors[:COUNT]
    before = fit.pose.project(given[ids])
    start, place = map_landmarks(before, landmark_map, "caricature"), pose.project(own)
    marks = []
    for shape in normal:
        after = fit.pose.project(shape[ids])
        way = map_landmarks(after, landmark_map, "caricature") - start
        length, most = (np.linalg.norm(w, axis=1, keepdims=True) for w in (way, FARTHEST * (after - before)))
        marks.append(place + way * np.minimum(1, most / np.maximum(length, 1e-12)))
    return np.array(marks)


def _reconstructed(vertices, pose, anchors, marks, given, normal, template, model):
    """(K, V, 3) the caricature with landmarks (K, 68, 2).

    In deformation gradients it starts with what the expression does to the normal face, added to its own, and the
    landmarks pull elastically. With a model, its latent takes the likeliest step that brings the landmarks there.
    """
    wanted = [(points - pose.project(vertices[anchors])) / pose.scale for points in marks]
    if model is not None:
        code = model.encode(vertices)
        steps = _latent_steps(model, code, anchors, pose.rotation, np.array(wanted))
        own = model.decode(code)
        return np.array([vertices + model.decode(code + step) - own for step in steps])
    gradients, elastic = template.gradients, ElasticAnchors(template.vertices, template.faces, np.unique(anchors))
    features, usual, shapes = gradients.features(vertices), gradients.features(given), []
    for points, shape in zip(marks, normal, strict=True):
        moved = gradients.vertices(features + EXAGGERATION * (gradients.features(shape) - usual))
        # Features do not say where; what hardly moves is where it was.
        way = np.linalg.norm(shape - given, axis=1)
        calm = way <= np.median(way)
        moved += (vertices[calm] - moved[calm]).mean(0)
        left = (points - pose.project(moved[anchors])) / pose.scale
        shapes.append(moved + elastic.move(*_distinct(anchors, left), STRENGTH) @ pose.rotation[:2])
    return np.array(shapes)


def _latent_steps(model, code, anchors, rotation, wanted):
    """(K, D) likeliest changes of a latent whose points move as wanted (K, L, 2), in metres across the picture."""
    noise = LatentSettings.noise * model.template.height
    _, jacobian = model.points_jacobian(code, anchors)
    seen = np.einsum("ab,lbd->lad", rotation[:2], jacobian @ model.prior.factor).reshape(2 * len(anchors), -1)
    system = seen.T @ seen + noise**2 * np.eye(seen.shape[1])
    whitened = np.linalg.solve(system, seen.T @ wanted.reshape(len(wanted), -1).T)
    return (model.prior.factor @ whitened).T


def _from_neutral(shapes, given):
    """(K, V, 3) displacements of the first shape from the given one, and of all others from the first.

    Equations 4 and 5 count all from the given one; of a face that smiles, each mask would then keep another share of
    that smile. On a neutral face there is no difference.
    """
    return np.concatenate([shapes[:1] - given, shapes[1:] - shapes[0]])


def _distinct(ids, moves):
    """Vertices without repeats; two moves of one are averaged."""
    kept, row = np.unique(ids, return_inverse=True)
    sums = np.zeros((len(kept), moves.shape[1]))
    np.add.at(sums, row, moves)
    return kept, sums / np.bincount(row)[:, None]


def _transferred(vertices, given, normal, held, faces):
    """(K, V, 3) the caricature doing what takes the given face to the normal ones."""
    transfer, everything = DeformationTransfer(vertices, faces, held), np.arange(len(faces))
    maps = (triangle_maps(given, shape, faces) for shape in normal)
    shifts = (normal - given).mean(1)
    return vertices + np.array([transfer.displacements(everything, m, s) for m, s in zip(maps, shifts, strict=True)])
