"""A 3D face from 2D landmarks that its surface follows elastically."""

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.untangle import untangle
from caricli.methods.reconstruct.camera_rows import CAMERA, camera_rows
from caricli.methods.reconstruct.landmark_fit import LandmarkFit, Observation
from caricli.methods.reconstruct.outline import Outline
from caricli.methods.reconstruct.settings import IntrinsicSettings, OutlierSettings
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.structures import Camera, Face

_OUTLIERS = OutlierSettings()


# The matrices are small: threads that wait for each other cost more than they bring, most of all on a busy machine.
@threadpool_limits.wrap(limits=1)
def fit_landmarks_intrinsic(
    points: np.ndarray,
    model: IntrinsicModel,
    settings: IntrinsicSettings = IntrinsicSettings(),  # noqa: B008 (frozen)
    outline: Outline | None = None,
) -> LandmarkFit:
    """Fit the likeliest face of the model, whose surface then follows the landmarks elastically.

    First camera, outline and latent in turns: the latent minimises ``sum_k w_k |s R[:2] p_k(z) + t - b_k|^2 / noise^2 +
    |z|^2``, by steps with the derivatives at the mean face; noise follows what the landmarks miss by. What no landmark
    sees, depth and neck and cheeks, so goes along with what they see as in the training faces. Then the smoothest
    correction takes the landmarks to their rays (depth is kept; Wu et al. 2018, expressions paper 3.2.1). An outlier
    among the landmarks loses its weight. Flipped triangles are turned back, the neck goes down with a chin that sank
    below it, and mouth cavity and eye sockets are tucked behind the skin.

    points: (L, 2) pixels, y down, NaN where unknown. model: IntrinsicModel. settings: IntrinsicSettings. outline: what
    was found in the picture besides 68 points, or None.
    Returns LandmarkFit; what the latent cannot express is in its residual. Raises InputError, NumericsError.
    """
    template = model.template
    observation = Observation(points, template, outline)
    latent, camera, weights = _likeliest(observation, model, settings)
    vertices = model.decode(latent)
    for number in range(settings.corrections):
        if number:
            vertices = untangle(vertices, template.gradients)
        vertices = template.neck.lengthen(vertices)
        anchors = observation.anchors(vertices, camera.rotation)
        camera = observation.camera(vertices, anchors, weights)
        gaps = observation.gaps(vertices, camera, anchors)
        pull = model.anchors.move(anchors[observation.ids], gaps, settings.strength, weights)
        vertices = vertices + pull @ camera.rotation[:2]
    vertices = template.cavities.tuck(vertices)
    residual = template.gradients.features(vertices) - model.features(latent)
    face = Face(template.with_vertices(vertices), camera, None, latent, residual, model.model_id)
    return observation.measure(face, model, weights, settings)


def _likeliest(
    observation: Observation, model: IntrinsicModel, settings: IntrinsicSettings
) -> tuple[np.ndarray, Camera, np.ndarray]:
    """The latent (D,) of the likeliest face, its Camera, and the weights (K,) of the landmarks."""
    latent = np.array(model.prior.mean)
    rotation = None
    weights = observation.trust
    for number in range(settings.rounds):
        shape = model.decode(latent)
        camera, anchors = observation.settle(shape, weights, rotation)
        rotation = camera.rotation
        errors = observation.errors(shape, camera, anchors)
        if number >= _OUTLIERS.first_round:
            weights = observation.weights(errors)
        noise = max(settings.least, settings.misfit * np.sqrt(np.average(errors**2, weights=weights)))
        ids = anchors[observation.ids]
        scale = np.sqrt(weights)[:, None] / noise
        tangent = model.tangent[np.searchsorted(model.anchors.points, ids)]
        rows = (camera_rows(shape[ids], tangent, camera) * scale[:, :, None]).reshape(2 * len(ids), -1)
        gaps = ((observation.points - camera.project(shape[ids])) * scale).ravel()
        # The camera may move along: a turn that explains the landmarks as well is no reason for another face.
        system = rows.T @ rows
        system[CAMERA:, CAMERA:] += np.eye(len(latent))
        likeliest = np.linalg.solve(system, rows.T @ (gaps + rows[:, CAMERA:] @ latent))[CAMERA:]
        # Derivatives are those at the mean face: far from it whole steps go to and fro.
        latent = latent + settings.step * (likeliest - latent)
    return latent, camera, weights
