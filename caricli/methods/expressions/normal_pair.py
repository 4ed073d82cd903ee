"""A caricature and the normal face that goes with it (expressions paper, section 3.2)."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.errors import InputError
from caricli.geometry.alignment.similarity import similarity
from caricli.methods.edit.map_landmarks import map_landmarks
from caricli.methods.expressions.settings import BlendshapeSettings
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.reconstruct.settings import LatentSettings
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face, Mesh
from caricli.structures.landmarks import COUNT


@dataclass(frozen=True, eq=False)
class Followed:
    """A caricature that does what a normal face does.

    shapes: (K, V, 3) in the size of the template.
    landmarks: (K, 68, 2) pixels, what they were reconstructed from.
    """

    shapes: np.ndarray
    landmarks: np.ndarray


class NormalPair:
    """A caricature in the size of the template, and the normal face that goes with it.

    The landmarks of the caricature, as its vertices show them, are mapped to those of a normal face, and the morphable
    model is fitted to these (equation 2).
    """

    def __init__(self, face: Face, tools: ExpressionTools, settings: BlendshapeSettings) -> None:
        """face: Face S(e_x) with the camera of its picture, of the mesh of the tools. Raises InputError."""
        camera = face.require_camera()
        morphable = tools.morphable
        self.face = face
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
        self.neutral = morphable.mean + np.tensordot(who, morphable.identity, 1)

    @property
    def mesh(self) -> Mesh:
        """Mesh of the caricature as it was given, in the size of the template."""
        return self.template.with_vertices(self.vertices)

    def follow(self, shapes: np.ndarray) -> Followed:
        """The caricature doing what the normal face does, its camera and all that landmarks do not show kept.

        shapes: (K, V, 3) of the normal face.
        """
        landmarks = self._landmarks(shapes)
        way = (
            self._in_latent(landmarks) if self.settings.reconstruct == "latent" else self._on_surface(landmarks, shapes)
        )
        return Followed(way, landmarks)

    def _landmarks(self, shapes: np.ndarray) -> np.ndarray:
        """(K, 68, 2) landmarks of the caricature with what the normal face does (equation 3).

        Of the many caricatures that a normal face has, the map back takes this one: what it adds to the normal face
        with the given expression it adds to every other, and where it is wider or longer as a whole, so are moves.
        """
        ids = self.fit.anchors[:COUNT]
        camera = self.fit.face.require_camera()
        before = camera.project(self.given[ids])
        stretch = np.linalg.lstsq(before - before.mean(0), self.own - self.own.mean(0), rcond=None)[0]
        return np.array([self.own + (camera.project(shape[ids]) - before) @ stretch for shape in shapes])

    def _on_surface(self, landmarks: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """(K, V, 3) the caricature with landmarks (K, 68, 2), as the normal face does it (K, V, 3).

        In deformation gradients it starts with what the expression does to the normal face, added to its own, and the
        landmarks pull elastically.
        """
        gradients = self.template.gradients
        features = gradients.features(self.vertices)
        usual = gradients.features(self.given)
        shapes = []
        for points, shape in zip(landmarks, normal, strict=True):
            acting = features + gradients.features(shape) - usual
            moved = gradients.vertices_like(acting, self.vertices + shape - self.given)
            # Features do not say where; what hardly moves is where it was.
            way = np.linalg.norm(shape - self.given, axis=1)
            calm = way <= np.median(way)
            moved += (self.vertices[calm] - moved[calm]).mean(0)
            left = (points - self.camera.project(moved[self.anchors])) / self.camera.scale
            pull = self.template.anchors.move(*_distinct(self.anchors, left), self.settings.strength)
            shapes.append(moved + pull @ self.camera.rotation[:2])
        return np.array(shapes)

    def _in_latent(self, landmarks: np.ndarray) -> np.ndarray:
        """(K, V, 3) the caricature with landmarks (K, 68, 2): the latent of a model takes the likeliest step there."""
        model = self.tools.latent
        if model is None:
            raise InputError("expected a model whose latent follows landmarks, found none")
        wanted = [(points - self.own) / self.camera.scale for points in landmarks]
        code = model.encode(self.vertices)
        steps = _latent_steps(model, code, self.anchors, self.camera.rotation, np.array(wanted))
        decoded = model.decode(code)
        return np.array([self.vertices + model.decode(code + step) - decoded for step in steps])


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


def _distinct(ids: np.ndarray, moves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices without repeats; two moves of one are averaged."""
    kept, row = np.unique(ids, return_inverse=True)
    sums = np.zeros((len(kept), moves.shape[1]))
    np.add.at(sums, row, moves)
    return kept, sums / np.bincount(row)[:, None]
