"""A face of the morphable model as the coarse network sees it in a picture."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from caricli.errors import InputError
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.alignment.similarity import similarity
from caricli.methods.morphable.coefficients import CoefficientLayout, turned_light
from caricli.methods.reconstruct.fit_landmarks_latent import fit_landmarks_latent
from caricli.methods.reconstruct.landmark_fit import LandmarkFit, Observation
from caricli.methods.reconstruct.settings import LatentSettings
from caricli.models.coarse.model import LANDMARKS, SHARE, CoarseModel
from caricli.models.morphable.model import MorphableModel, ShapeBases
from caricli.render.pixels.cut_window import cut_window
from caricli.structures import Camera, Face
from caricli.structures.detection import FaceFrame
from caricli.structures.landmarks import COUNT, FEWEST

ALONE = LatentSettings(rounds=0, refinements=0)
"""Of no fit at all."""


@dataclass(frozen=True, eq=False)
class CoarseFit(LandmarkFit):
    """A LandmarkFit with the word of the network.

    coefficients: by the names of CoefficientLayout, before the face was brought nearer to the landmarks; light and pose
    are those of the given picture, as a PhotometricFit has them.
    """

    coefficients: dict[str, np.ndarray] | None = None

    def figures(self) -> dict[str, Any]:
        """What reports say of the fit, as JSON."""
        return super().figures() | {"coefficients": self.coefficients}


@dataclass(frozen=True, eq=False)
class CoarseSight:
    """What the network sees. coefficients: (D,), light and pose of the picture. camera: Camera of the picture."""

    coefficients: np.ndarray
    camera: Camera


def see_coarse(
    points: np.ndarray,
    image: np.ndarray,
    network: CoarseModel,
    model: MorphableModel,
    spreads: np.ndarray | None = None,
) -> CoarseSight:
    """Let the network look at the face of a picture (H, W, 3) uint8 that has landmarks (L, 2), NaN where unknown.

    spreads: (L, 2, 2) covariances of their errors, square pixels, or None.
    """
    told = np.full((LANDMARKS, 2), np.nan)
    told[: len(points)] = points
    doubts = np.full((LANDMARKS, 2, 2), np.nan)
    if spreads is not None:
        doubts[: len(points)] = spreads
    frame = FaceFrame.of(_filled(points[:COUNT], model))
    matrix = frame.matrix(network.size, SHARE)
    window = cut_window(image, matrix, (network.size, network.size))
    linear = matrix[:, :2]
    marks = (told @ linear.T + matrix[:, 2], linear @ doubts @ linear.T)
    coefficients = network.read(window[None], *(value[None] for value in marks))[0]
    layout = CoefficientLayout.of(model)
    parts = layout.parts(coefficients)
    parts["light"][:] = turned_light(parts["light"], frame.roll)
    pose = parts["pose"]
    pose[2] += frame.roll
    pose[3:5] = np.linalg.solve(linear, pose[3:5] - matrix[:, 2])
    pose[5] /= np.sqrt(np.linalg.det(linear))
    middle = model.decode(coefficients[: layout.shape]).mean(0)
    rotation = head_rotation(pose[:3])
    return CoarseSight(coefficients, Camera(float(pose[5]), rotation, pose[3:5] - pose[5] * rotation[:2] @ middle))


def fit_coarse(
    points: np.ndarray,
    model: MorphableModel,
    network: CoarseModel,
    image: np.ndarray | None,
    alone: bool = False,
    spreads: np.ndarray | None = None,
) -> CoarseFit:
    """The face that the network sees, brought nearer to the landmarks as far as it is usually wrong.

    Minimises ``sum_n w_n |q_n - p_n|^2 / noise^2 + |(z - z_0) / d|^2`` over the camera and the latent z by
    ``fit_landmarks_latent``: as ``fit_morphable`` does, but about what the network says, z_0, and with its usual errors
    d, measured on people whom it was not trained with, in place of the deviations of all faces.

    points: (L, 2) pixels, y down, NaN where unknown. model: the MorphableModel that the network was trained for. image:
    (H, W, 3) uint8. alone: take the network's word for the shape; the camera is that which meets the landmarks best.
    spreads: (L, 2, 2) covariances of the points' errors, square pixels, or None; they add to the noise.
    Returns CoarseFit; its latent is the model's. Raises InputError, NumericsError.
    """
    if image is None:
        raise InputError("expected a picture, found landmarks without one; --image takes theirs")
    sight = see_coarse(points, image, network, model, spreads)
    layout = CoefficientLayout.of(model)
    start = sight.coefficients[: layout.shape]
    if alone:
        fit = _taken(Observation(points, model.template, spreads=spreads), model, start, sight.camera)
    else:
        doubt = network.doubt[: layout.shape]
        basis = model.basis * doubt[:, None, None]
        bases = ShapeBases(model.decode(start), basis[: layout.identity], basis[layout.identity :], model.noise)
        fit = fit_landmarks_latent(points, MorphableModel(model.template, bases, model.albedo), spreads=spreads)
        start = start + doubt * fit.face.require_latent()
    return _reported(fit, start, sight, model)


def _taken(observation: Observation, model: MorphableModel, latent: np.ndarray, camera: Camera) -> LandmarkFit:
    """The LandmarkFit of a latent (D,) as it is."""
    face = Face(model.template.with_vertices(model.decode(latent)), camera, latent=latent)
    return observation.measure(face, model, observation.trust, ALONE)


def _reported(fit: LandmarkFit, latent: np.ndarray, sight: CoarseSight, model: MorphableModel) -> CoarseFit:
    """The fit as one of the model, with what the network said."""
    face = replace(fit.face, latent=latent, model_id=model.model_id)
    own = {each.name: getattr(fit, each.name) for each in fields(LandmarkFit)}
    own |= {"face": face, "prior_rms": float(model.prior.rms(latent))}
    return CoarseFit(**own, coefficients=CoefficientLayout.of(model).report(sight.coefficients))


def _filled(points: np.ndarray, model: MorphableModel) -> np.ndarray:
    """Landmarks of iBUG (68, 2) with those of the model's mean, seen from the front, where they are not known."""
    known_rows = np.isfinite(points).all(1)
    if known_rows.all():
        return points
    if known_rows.sum() < FEWEST:
        raise InputError(f"expected at least {FEWEST} known landmarks, found {known_rows.sum()}")
    front = model.mean[model.template.annotation.landmarks[:COUNT], :2] * [1, -1]
    scale, rotation, translation = similarity(front[known_rows], points[known_rows])
    return np.where(known_rows[:, None], points, scale * front @ rotation.T + translation)
