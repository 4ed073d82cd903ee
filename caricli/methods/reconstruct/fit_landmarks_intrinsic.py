"""A 3D face from 2D landmarks that its surface follows elastically."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.repair.untangle import untangle
from caricli.methods.reconstruct.camera_rows import CAMERA, camera_rows
from caricli.methods.reconstruct.landmark_fit import LandmarkFit, Observation
from caricli.methods.reconstruct.outline import Outline
from caricli.methods.reconstruct.settings import IntrinsicSettings, OutlierSettings
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.structures import Camera, Face
from caricli.structures.landmarks import EAR_LEFT, EAR_RIGHT, INNER

_OUTLIERS = OutlierSettings()

_EARS = {"ear_left": EAR_LEFT, "ear_right": EAR_RIGHT}
"""Regions with the landmarks that show them."""


@dataclass(frozen=True, eq=False)
class _Likeliest:
    """The likeliest face of the model for some landmarks.

    latent: (D,). camera: Camera. weights: (K,) of the landmarks. noise: how far these are expected from where the model
    puts them, a share of their diagonal.
    """

    latent: np.ndarray
    camera: Camera
    weights: np.ndarray
    noise: float


# The matrices are small: threads that wait for each other cost more than they bring, most of all on a busy machine.
@threadpool_limits.wrap(limits=1)
def fit_landmarks_intrinsic(
    points: np.ndarray,
    model: IntrinsicModel,
    settings: IntrinsicSettings = IntrinsicSettings(),  # noqa: B008 (frozen)
    look: Callable[[Face], Outline] | None = None,
    spreads: np.ndarray | None = None,
) -> LandmarkFit:
    """Fit the likeliest face of the model, whose surface then follows the landmarks elastically.

    First camera, outline and latent in turns: the latent minimises ``sum_k w_k |s R[:2] p_k(z) + t - b_k|^2 / noise^2 +
    |z|^2``, by steps with the derivatives at the mean face; noise follows what the landmarks miss by. What no landmark
    sees, depth and neck and cheeks, so goes along with what they see as in the training faces. Then the smoothest
    correction takes the landmarks to their rays (depth is kept; Wu et al. 2018, expressions paper 3.2.1), in turns with
    a latent that follows it: towards the smallest ``|f - f(z)|^2 + follow |z - likeliest|^2`` for the features f of the
    corrected surface, so that a nose or lip that was pulled gets the depth of such a nose or lip. It goes only the
    share of the way that the model leaves unexplained, 1 - least / noise, and by that share ears that no landmark shows
    go back to the mean face's. An outlier among the landmarks loses its weight. Flipped triangles are turned back, the
    neck goes down with a chin that sank below it, and mouth cavity and eye sockets are tucked behind the skin.

    points: (L, 2) pixels, y down, NaN where unknown. model: IntrinsicModel. settings: IntrinsicSettings. look: what is
    found in the picture besides 68 points around the likeliest face for these, corrected once; where there is anything,
    the likeliest face for all of it follows in a few rounds more. spreads: (L, 2, 2) covariances of the points' errors,
    square pixels, or None: a landmark pulls by what it is sure of, in the direction in which it is.
    Returns LandmarkFit; what the latent cannot express is in its residual. Raises InputError, NumericsError.
    """
    template = model.template
    observation = Observation(points, template, None, spreads)
    likeliest = _likeliest(observation, model, settings)
    outline = None
    if look is not None:
        first = _Surface(observation, model, settings, likeliest)
        seen = template.with_vertices(first.correct(first.shape(likeliest.latent)))
        outline = look(Face(seen, observation.in_pixels(first.camera)))
        if outline.found:
            observation = Observation(points, template, outline, spreads)
            likeliest = _likeliest(observation, model, settings, likeliest)
    surface = _Surface(observation, model, settings, likeliest)
    latent = likeliest.latent
    for _ in range(settings.turns if surface.strange else 0):
        latent = surface.follow(surface.correct(surface.shape(latent)), latent)
    vertices = surface.shape(latent)
    for number in range(settings.corrections):
        vertices = surface.correct(untangle(vertices, template.gradients) if number else vertices)
    vertices = template.cavities.tuck(vertices)
    residual = template.gradients.features(vertices) - model.features(latent)
    face = Face(template.with_vertices(vertices), surface.camera, None, latent, residual, model.model_id)
    weights = observation.shares(likeliest.weights, likeliest.noise)
    fit = observation.measure(face, model, weights, settings)
    again = settings.again if outline is not None and outline.found else 0
    return replace(fit, outline=outline, rounds=settings.rounds + again)


class LandmarkChase:
    """A face that follows landmarks while they are dragged, in about a twentieth of the time of a whole fit.

    Every look goes on where the one before it ended, with one round of camera, outline and latent and two corrections
    of the surface. Its lines are then about 0.2 to 0.3 % of the landmarks' diagonal from those of a whole fit, of
    strange faces 1 %: no latent follows the corrections. Flipped triangles and what is behind the skin stay as they
    are.
    """

    def __init__(self, model: IntrinsicModel, settings: IntrinsicSettings = IntrinsicSettings()) -> None:  # noqa: B008
        """model: IntrinsicModel. settings: of the fit (frozen)."""
        self.model = model
        self.settings = settings
        self._likeliest: _Likeliest | None = None

    @threadpool_limits.wrap(limits=1)
    def look(self, points: np.ndarray, spreads: np.ndarray | None = None) -> Face:
        """The face for landmarks (L, 2), with camera and landmarks; the first look takes all rounds of a fit.

        points, spreads: as in ``fit_landmarks_intrinsic``; others than before may be known. Raises InputError,
        NumericsError.
        """
        observation = Observation(points, self.model.template, None, spreads)
        first = self._likeliest
        if first is not None:
            first = replace(first, camera=observation.in_units(first.camera))
        settings = replace(self.settings, again=1)
        likeliest = _likeliest(observation, self.model, settings, first)
        surface = _Surface(observation, self.model, self.settings, likeliest)
        vertices = surface.correct(surface.correct(surface.shape(likeliest.latent)))
        camera = observation.in_pixels(surface.camera)
        self._likeliest = replace(likeliest, camera=observation.in_pixels(likeliest.camera))
        anchors = observation.anchors(vertices, camera.rotation)
        landmarks = camera.project(vertices[anchors])
        return Face(self.model.template.with_vertices(vertices), camera, landmarks, model_id=self.model.model_id)


class _Surface:
    """A surface that follows the landmarks elastically. camera: Camera that it was last seen with."""

    def __init__(
        self, observation: Observation, model: IntrinsicModel, settings: IntrinsicSettings, likeliest: _Likeliest
    ) -> None:
        """likeliest: where it begins."""
        self.observation = observation
        self.model = model
        self.settings = settings
        self.likeliest = likeliest
        self.camera = likeliest.camera
        # The share that the model leaves unexplained: 0 for faces like its own, towards 1 far from all of them.
        self.strange = 1 - settings.least / likeliest.noise
        # (K, 1, 1) how far the shape is expected from exact landmarks: within a strange face farther.
        inner = np.isin(observation.ids, INNER)[:, None, None]
        self.exact = settings.exact * np.where(inner, likeliest.noise / settings.least, 1) ** 2
        unseen = [name for name, numbers in _EARS.items() if not np.isin(numbers, observation.ids).any()]
        # (V, 1) how much of what a latent makes of the mean face is left out.
        self.usual = self.strange * model.template.mask(*unseen)[:, None]

    def shape(self, latent: np.ndarray) -> np.ndarray:
        """(V, 3) of a latent (D,), unseen ears more usual than it has them."""
        return self.model.decode(latent, -self.usual * (self.model.features(latent) - self.model.mean))

    def correct(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) taken to the landmarks' rays, the neck down to the chin."""
        observation = self.observation
        weights = self.likeliest.weights
        vertices = self.model.template.neck.lengthen(vertices)
        anchors = observation.anchors(vertices, self.camera.rotation)
        self.camera = observation.camera(vertices, anchors, observation.shares(weights, self.likeliest.noise))
        gaps = observation.gaps(vertices, self.camera, anchors)
        confidence = observation.confidence(self.exact)
        pulls = weights if confidence is None else weights[:, None, None] * confidence
        pull = self.model.template.anchors.move(anchors[observation.ids], gaps, self.settings.strength, pulls)
        return vertices + pull @ self.camera.rotation[:2]

    def follow(self, vertices: np.ndarray, latent: np.ndarray) -> np.ndarray:
        """The latent (D,) for what a correction made, vertices (V, 3), of the shape of a latent (D,)."""
        model = self.model
        start = self.likeliest.latent
        features = model.template.gradients.features(vertices) + self.usual * (model.features(latent) - model.mean)
        change = features - model.features(start) + model.mean
        return start + self.strange * model.features_to_latent(change, self.settings.follow)


def _likeliest(
    observation: Observation, model: IntrinsicModel, settings: IntrinsicSettings, first: _Likeliest | None = None
) -> _Likeliest:
    """The likeliest face. first: the one for less landmarks of the same face, to begin with, or None."""
    latent = np.array(model.prior.mean) if first is None else first.latent
    rotation = None if first is None else first.camera.rotation
    weights = observation.trust
    noise = _OUTLIERS.floor if first is None else first.noise
    for number in range(settings.rounds) if first is None else range(settings.rounds, settings.rounds + settings.again):
        shape = model.decode(latent)
        camera, anchors = observation.settle(shape, observation.shares(weights, noise), rotation)
        rotation = camera.rotation
        errors = observation.errors(shape, camera, anchors, noise)
        if number >= _OUTLIERS.first_round:
            weights = observation.weights(errors)
        spread = np.average(errors**2, weights=observation.shares(weights, noise))
        noise = max(settings.least, settings.misfit * np.sqrt(spread))
        ids = anchors[observation.ids]
        scale = np.sqrt(weights)[:, None] / noise
        tangent = model.tangent[np.searchsorted(model.template.anchors.points, ids)]
        rows = observation.whitened(camera_rows(shape[ids], tangent, camera) * scale[:, :, None], noise)
        rows = rows.reshape(2 * len(ids), -1)
        gaps = observation.whitened((observation.points - camera.project(shape[ids])) * scale, noise).ravel()
        # The camera may move along: a turn that explains the landmarks as well is no reason for another face.
        system = rows.T @ rows
        system[CAMERA:, CAMERA:] += np.eye(len(latent))
        likeliest = np.linalg.solve(system, rows.T @ (gaps + rows[:, CAMERA:] @ latent))[CAMERA:]
        # Derivatives are those at the mean face: far from it whole steps go to and fro.
        latent = latent + settings.step * (likeliest - latent)
    return _Likeliest(latent, camera, weights, noise)
