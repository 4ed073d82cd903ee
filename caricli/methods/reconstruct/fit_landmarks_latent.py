"""A 3D face from 2D landmarks that stays inside a shape model."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.gauss_newton import Damping
from caricli.methods.reconstruct.camera_rows import CAMERA, camera_rows, moved_camera
from caricli.methods.reconstruct.landmark_fit import LandmarkFit, Observation
from caricli.methods.reconstruct.outline import Outline
from caricli.methods.reconstruct.settings import DampingSettings, LatentSettings, OutlierSettings
from caricli.models.shape_model import ShapeModel
from caricli.structures import Camera, Face

_OUTLIERS = OutlierSettings()
_DAMPING = DampingSettings()


@threadpool_limits.wrap(limits=1)
def fit_landmarks_latent(
    points: np.ndarray,
    model: ShapeModel,
    settings: LatentSettings = LatentSettings(),  # noqa: B008 (frozen)
    look: Callable[[Face], Outline] | None = None,
    spreads: np.ndarray | None = None,
) -> LandmarkFit:
    """Fit a face that stays inside a shape model (deformable paper, equation 3 and supplement 5).

    Minimises ``sum_k w_k |s R[:2] p_k(z) + t - b_k|^2 / noise^2 + |whitened z|^2`` over camera and latent: alternating
    rounds of camera, outline and latent, then Levenberg-Marquardt steps on all together, then a last camera. Only the
    points that landmarks can stand on are decoded.

    points: (L, 2) pixels, y down, NaN where unknown. model: any ShapeModel. settings: LatentSettings.
    look: what is found in the picture besides 68 points around a fit to these; where there is anything, another fit
    follows. spreads: (L, 2, 2) covariances of the points' errors, square pixels, or None; they add to the noise.
    Returns LandmarkFit without a residual. Raises InputError, NumericsError.
    """
    fit = _fit(Observation(points, model.template, None, spreads), model, settings)
    if look is None:
        return fit
    outline = look(fit.face)
    if outline.found:
        other = _fit(Observation(points, model.template, outline, spreads), model, settings)
        fit = replace(other, rounds=fit.rounds + other.rounds)
    return replace(fit, outline=outline)


def _fit(observation: Observation, model: ShapeModel, settings: LatentSettings) -> LandmarkFit:
    search = _Search(observation, model, settings.noise)
    damping = Damping(_DAMPING.start, _DAMPING.ease, _DAMPING.tighten)
    rounds = settings.rounds + settings.refinements
    for number in range(rounds):
        joint = number >= settings.rounds
        search.look(joint, robust=number >= _OUTLIERS.first_round)
        search.descend(joint, damping)
    latent = model.prior.colour(search.whitened)
    mesh = model.template.with_vertices(model.decode(latent))
    face = Face(mesh, search.camera, latent=latent, model_id=model.model_id)
    fit = observation.measure(face, model, observation.shares(search.weights, settings.noise), settings)
    return replace(fit, rounds=rounds)


class _Search:
    """Where a fit inside a model is: camera, whitened latent (D,), anchors (L,), and weights (K,) of the landmarks."""

    def __init__(self, observation: Observation, model: ShapeModel, noise: float) -> None:
        """noise: expected error of a landmark as a share of the diagonal. It begins with the model's mean shape."""
        self.observation = observation
        self.model = model
        self.noise = noise
        self.candidates = model.template.annotation.anchor_ids()
        self.whitened = np.zeros(len(model.prior.mean))
        self.camera, self.anchors = observation.settle(self.shape(self.whitened))
        self.weights = observation.trust

    def shape(self, whitened: np.ndarray) -> np.ndarray:
        """(V, 3) vertices that landmarks can stand on, the others at zero."""
        sparse = np.zeros_like(self.model.template.vertices)
        sparse[self.candidates] = self.model.decode_points(self.model.prior.colour(whitened), self.candidates)
        return sparse

    def look(self, joint: bool, robust: bool) -> None:
        """Find what the landmarks stand on. joint: keep the camera. robust: tell outliers apart."""
        shape = self.shape(self.whitened)
        if joint:
            self.anchors = self.observation.anchors(shape, self.camera.rotation)
        else:
            weights = self.observation.shares(self.weights, self.noise)
            self.camera, self.anchors = self.observation.settle(shape, weights, self.camera.rotation)
        if robust:
            errors = self.observation.errors(shape, self.camera, self.anchors, self.noise)
            self.weights = self.observation.weights(errors)

    def descend(self, joint: bool, damping: Damping) -> None:
        """Take a step that lowers the cost, if one of a few does. joint: of camera and latent, else of the latent."""
        system, right = self.normal_equations()
        if not joint:
            system = system[CAMERA:, CAMERA:]
            right = right[CAMERA:]
        before = self.cost(self.camera, self.whitened)
        for _ in range(_DAMPING.tries):
            step = damping.step(system, right)
            camera = moved_camera(self.camera, step[:CAMERA]) if joint else self.camera
            whitened = self.whitened + step[-len(self.whitened) :]
            if self.cost(camera, whitened) < before:
                self.camera = camera
                self.whitened = whitened
                damping.accept()
                break
            damping.reject()

    def cost(self, camera: Camera, whitened: np.ndarray) -> float:
        """What is minimised, for anchors and weights as they are."""
        errors = self.observation.errors(self.shape(whitened), camera, self.anchors, self.noise)
        return (self.weights * errors**2).sum() / self.noise**2 + (whitened**2).sum()

    def normal_equations(self) -> tuple[np.ndarray, np.ndarray]:
        """Gauss-Newton system (6 + D, 6 + D) and right side for camera and latent."""
        camera = self.camera
        latent = self.model.prior.colour(self.whitened)
        positions, jacobian = self.model.points_jacobian(latent, self.anchors[self.observation.ids])
        rows = camera_rows(positions, jacobian @ self.model.prior.factor, camera)
        scale = np.sqrt(self.weights)[:, None] / self.noise
        gaps = (self.observation.points - camera.project(positions)) * scale
        residual = self.observation.whitened(gaps, self.noise).ravel()
        rows = self.observation.whitened(rows * scale[:, :, None], self.noise).reshape(len(residual), -1)
        system = rows.T @ rows
        right = rows.T @ residual
        system[CAMERA:, CAMERA:] += np.eye(len(self.whitened))
        right[CAMERA:] -= self.whitened
        return system, right
