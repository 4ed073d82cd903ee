"""A 3D face from 2D landmarks that its surface follows elastically."""

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.untangle import untangle
from caricli.methods.reconstruct.landmark_fit import LandmarkFit, Observation, outlier_weights
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
) -> LandmarkFit:
    """Fit a face whose surface follows the landmarks elastically while its features stay near the model's.

    Alternates, after Wu et al. 2018 (expressions paper 3.2.1): camera; jaw landmarks to the outline; the smoothest
    correction of the model's shape that takes the landmarks to their rays (depth is kept); and the latent as the shrunk
    projection of the result's deformation-gradient features. An outlier among the landmarks loses its weight. At the
    end flipped triangles are turned back and mouth cavity and eye sockets are tucked behind the skin.

    points: (L, 2) pixels, y down, NaN where unknown. model: IntrinsicModel. settings: IntrinsicSettings.
    Returns LandmarkFit; what the latent cannot express is in its residual. Raises InputError, NumericsError.
    """
    template = model.template
    observation = Observation(points, template)
    vertices, camera, weights = _follow(observation, model, settings)
    vertices = untangle(vertices, template.gradients)
    anchors = observation.anchors(vertices, camera.rotation)
    last = observation.camera(vertices, anchors, weights)
    gaps = observation.gaps(vertices, last, anchors)
    pull = model.anchors.move(anchors[observation.ids], gaps, settings.strength, weights)
    vertices = template.cavities.tuck(vertices + pull @ last.rotation[:2])
    features = template.gradients.features(vertices)
    latent = model.features_to_latent(features, settings.shrink)
    residual = features - model.features(latent)
    face = Face(template.with_vertices(vertices), camera, None, latent, residual, model.model_id)
    return observation.measure(face, model, weights, settings)


def _follow(
    observation: Observation, model: IntrinsicModel, settings: IntrinsicSettings
) -> tuple[np.ndarray, Camera, np.ndarray]:
    """Vertices (V, 3) that meet the landmarks, the Camera, and the weights (K,) of the landmarks."""
    latent = np.array(model.prior.mean)
    rotation = None
    weights = np.ones(len(observation.ids))
    for number in range(settings.rounds):
        shape = model.decode(latent)
        camera, anchors = observation.settle(shape, weights, rotation)
        rotation = camera.rotation
        gaps = observation.gaps(shape, camera, anchors)
        if number >= _OUTLIERS.first_round:
            weights = outlier_weights(np.linalg.norm(gaps, axis=1) * camera.scale, _OUTLIERS)
        pull = model.anchors.move(anchors[observation.ids], gaps, settings.strength, weights)
        vertices = shape + pull @ rotation[:2]
        latent = model.features_to_latent(model.template.gradients.features(vertices), settings.shrink)
    return vertices, camera, weights
