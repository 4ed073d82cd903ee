"""Expressions of a caricature from those of a normal face (expressions paper, section 3.2)."""

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.errors import InputError
from caricli.geometry.deformation_transfer import DeformationTransfer, triangle_maps
from caricli.geometry.elastic_anchors import ElasticAnchors
from caricli.geometry.similarity import similarity
from caricli.methods.edit.map_landmarks import map_landmarks
from caricli.methods.expressions.optimise_blendshapes import (
    UNMOVED,
    displacement_masks,
    optimise_blendshapes,
)
from caricli.methods.expressions.settings import BlendshapeSettings
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.reconstruct.settings import LatentSettings
from caricli.methods.rig.keep_contacts import Contacts
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face
from caricli.structures.arkit import start_delta
from caricli.structures.landmarks import COUNT


@dataclass(frozen=True, eq=False)
class Blendshapes:
    """Expressions of a caricature and of a normal face.

    shapes: (K, V, 3) metres, of the caricature, the neutral one first.
    normal: (K, V, 3) metres, of the normal face.
    normal_given: (V, 3) metres, the normal face with the expression of the picture.
    fit: LandmarkFit of the normal face.
    landmarks: (K, 68, 2) pixels, of the caricature; or None.
    """

    shapes: np.ndarray
    normal: np.ndarray
    normal_given: np.ndarray
    fit: LandmarkFit
    landmarks: np.ndarray | None


# The matrices are small: threads that wait for each other cost more than they bring.
@threadpool_limits.wrap(limits=1)
def build_blendshapes(
    face: Face,
    tools: ExpressionTools,
    settings: BlendshapeSettings = BlendshapeSettings(),  # noqa: B008 (frozen)
) -> Blendshapes:
    """Build the expressions of a caricature that shows one of its own.

    The landmarks of the caricature, as its vertices show them, are mapped to those of a normal face, and the morphable
    model is fitted to these (equation 2). With each expression in the place of its own (equation 3) the landmarks move,
    are mapped back, and the caricature is reconstructed from them, its camera and everything that landmarks do not show
    kept. "initial" stops there; "full" optimises the displacements (equations 4 to 11) and lets lids and lips meet;
    "transfer" instead transfers the deformations of the normal face (Sumner and Popovic 2004).

    face: Face S(e_x) with the camera of its picture, of the mesh of the tools.
    Raises InputError, NumericsError.
    """
    pair = _Pair(face, tools, settings)
    landmarks = None
    if settings.method == "transfer":
        shapes = pair.transfer()
    else:
        landmarks = pair.caricature_landmarks()
        shapes = pair.follow_latent(landmarks) if settings.reconstruct == "latent" else pair.follow(landmarks)
    if settings.method == "full":
        shapes = pair.optimise(shapes)
    return Blendshapes(pair.scale * shapes, pair.normal, pair.given, pair.fit, landmarks)


class _Pair:
    """A caricature in the size of the template, and the normal face that goes with it."""

    def __init__(self, face: Face, tools: ExpressionTools, settings: BlendshapeSettings) -> None:
        camera = face.require_camera()
        morphable = tools.morphable
        self.tools = tools
        self.settings = settings
        self.template = morphable.template
        self.scale, *_ = similarity(self.template.vertices, face.vertices)
        self.vertices = face.vertices / self.scale
        self.camera = replace(camera, scale=camera.scale * self.scale)
        self.anchors = landmark_vertices(self.vertices, self.camera.rotation, self.template, COUNT)
        self.own = self.camera.project(self.vertices[self.anchors])
        self.fit = fit_morphable(map_landmarks(self.own, tools.landmark_map, "normal"), morphable)
        latent = self.fit.face.require_latent()
        who, _ = morphable.parts(latent)
        self.given = morphable.decode(latent)
        neutral = morphable.mean + np.tensordot(who, morphable.identity, 1)
        self.normal = neutral + tools.templates.deltas
        self.held = displacement_masks(tools.templates.deltas).max(0) < UNMOVED

    def caricature_landmarks(self) -> np.ndarray:
        """(K, 68, 2) landmarks of the caricature with every expression.

        Mapped differences are added to its own landmarks, so that what the map loses stays.
        """
        ids = self.fit.anchors[:COUNT]
        before = self.fit.face.require_camera().project(self.given[ids])
        start = map_landmarks(before, self.tools.landmark_map, "caricature")
        landmarks = []
        for shape in self.normal:
            after = self.fit.face.require_camera().project(shape[ids])
            way = map_landmarks(after, self.tools.landmark_map, "caricature") - start
            length = np.linalg.norm(way, axis=1, keepdims=True)
            most = np.linalg.norm(self.settings.farthest * (after - before), axis=1, keepdims=True)
            landmarks.append(self.own + way * np.minimum(1, most / np.maximum(length, 1e-12)))
        return np.array(landmarks)

    def follow(self, landmarks: np.ndarray) -> np.ndarray:
        """(K, V, 3) the caricature with landmarks (K, 68, 2).

        In deformation gradients it starts with what the expression does to the normal face, added to its own, and the
        landmarks pull elastically.
        """
        gradients = self.template.gradients
        elastic = ElasticAnchors(self.template.vertices, self.template.faces, np.unique(self.anchors))
        features = gradients.features(self.vertices)
        usual = gradients.features(self.given)
        shapes = []
        for points, shape in zip(landmarks, self.normal, strict=True):
            acting = features + self.settings.exaggeration * (gradients.features(shape) - usual)
            moved = gradients.vertices_like(acting, self.vertices + shape - self.given)
            # Features do not say where; what hardly moves is where it was.
            way = np.linalg.norm(shape - self.given, axis=1)
            calm = way <= np.median(way)
            moved += (self.vertices[calm] - moved[calm]).mean(0)
            left = (points - self.camera.project(moved[self.anchors])) / self.camera.scale
            pull = elastic.move(*_distinct(self.anchors, left), self.settings.strength)
            shapes.append(moved + pull @ self.camera.rotation[:2])
        return np.array(shapes)

    def follow_latent(self, landmarks: np.ndarray) -> np.ndarray:
        """(K, V, 3) the caricature with landmarks (K, 68, 2): the latent of a model takes the likeliest step there."""
        model = self.tools.latent
        if model is None:
            raise InputError("expected a model whose latent follows landmarks, found none")
        own = self.camera.project(self.vertices[self.anchors])
        wanted = [(points - own) / self.camera.scale for points in landmarks]
        code = model.encode(self.vertices)
        steps = _latent_steps(model, code, self.anchors, self.camera.rotation, np.array(wanted))
        decoded = model.decode(code)
        return np.array([self.vertices + model.decode(code + step) - decoded for step in steps])

    def optimise(self, shapes: np.ndarray) -> np.ndarray:
        """(K, V, 3) shapes that exaggerate no more than the normal face's and relate as they do, the neutral first."""
        initial = _from_neutral(shapes, self.vertices)
        normal = _from_neutral(self.normal, self.given)
        # What the fit makes of a neutral face is noise; an expression worth its name moves as far as others do.
        usual = np.median(np.linalg.norm(normal, axis=2).max(1))
        least = np.where(np.arange(len(shapes)) == 0, usual, 0.0)
        mesh = self.template.with_vertices(self.vertices)
        deltas = optimise_blendshapes(initial, normal, mesh, self.settings.weights, least)
        neutral = self.vertices + deltas[0]
        deltas[0] = 0
        if self.settings.contacts:
            deltas = self._in_contact(neutral, deltas)
        return neutral + deltas

    def _in_contact(self, neutral: np.ndarray, deltas: np.ndarray) -> np.ndarray:
        """The displacements (K, V, 3) of a neutral face (V, 3), lids and lips meeting as they do on the templates."""
        templates = self.tools.templates
        contacts = Contacts(templates, neutral, DeformationTransfer(neutral, self.template.faces, self.held))
        kept = np.array(deltas)
        for k in templates.order:
            if templates.motions[k] is not None:
                start = start_delta(templates.names, kept, k)
                kept[k] = contacts.keep(k, kept[k] + start) - start
        return kept

    def transfer(self) -> np.ndarray:
        """(K, V, 3) the caricature doing what takes the given normal face to the others."""
        faces = self.template.faces
        deformations = DeformationTransfer(self.vertices, faces, self.held)
        everything = np.arange(len(faces))
        maps = (triangle_maps(self.given, shape, faces) for shape in self.normal)
        ways = self.normal - self.given
        moves = [deformations.displacements(everything, m, way) for m, way in zip(maps, ways, strict=True)]
        return self.vertices + np.array(moves)


def _latent_steps(
    model: ShapeModel, code: np.ndarray, anchors: np.ndarray, rotation: np.ndarray, wanted: np.ndarray
) -> np.ndarray:
    """(K, D) likeliest changes of a latent whose points move as wanted (K, L, 2), in metres across the picture."""
    noise = LatentSettings.noise * model.template.height
    _, jacobian = model.points_jacobian(code, anchors)
    seen = np.einsum("ab,lbd->lad", rotation[:2], jacobian @ model.prior.factor).reshape(2 * len(anchors), -1)
    system = seen.T @ seen + noise**2 * np.eye(seen.shape[1])
    whitened = np.linalg.solve(system, seen.T @ wanted.reshape(len(wanted), -1).T)
    return (model.prior.factor @ whitened).T


def _from_neutral(shapes: np.ndarray, given: np.ndarray) -> np.ndarray:
    """(K, V, 3) displacements of the first shape from the given one, and of all others from the first.

    Equations 4 and 5 count all from the given one; of a face that smiles, each mask would then keep another share of
    that smile. On a neutral face there is no difference.
    """
    return np.concatenate([shapes[:1] - given, shapes[1:] - shapes[0]])


def _distinct(ids: np.ndarray, moves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices without repeats; two moves of one are averaged."""
    kept, row = np.unique(ids, return_inverse=True)
    sums = np.zeros((len(kept), moves.shape[1]))
    np.add.at(sums, row, moves)
    return kept, sums / np.bincount(row)[:, None]
