"""A face of the morphable model from 2D landmarks: the coarse geometry of the portrait paper."""

from dataclasses import replace

import numpy as np

from caricli.errors import InputError
from caricli.methods.reconstruct.fit_landmarks_latent import fit_landmarks_latent
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.methods.reconstruct.settings import MorphableWeights
from caricli.models.morphable.model import MorphableModel, ShapeBases


def fit_morphable(
    points: np.ndarray,
    model: MorphableModel,
    weights: MorphableWeights = MorphableWeights(),  # noqa: B008 (frozen)
    identity: np.ndarray | None = None,
    spreads: np.ndarray | None = None,
) -> LandmarkFit:
    """Fit identity, expression and camera (equations 7 and 8, squared, with the regularisation of equation 6).

    Minimises ``sum_n w_n |q_n - p_n|^2 / noise^2 + weights.identity |a|^2 + weights.expression |b|^2`` over the camera
    and the coefficients a and b by ``fit_landmarks_latent``; distances are shares of the landmarks' diagonal.

    points: (L, 2) pixels, y down, NaN where unknown. model: MorphableModel. weights: MorphableWeights. identity: (I,)
    coefficients that stay as they are ("Adjust Exp"), or None to fit them too. spreads: (L, 2, 2) covariances of the
    points' errors, square pixels, or None; they add to the noise.
    Returns LandmarkFit; its latent is the model's. Raises InputError, NumericsError.
    """
    who = model.identity / weights.identity**0.5
    what = model.expression / weights.expression**0.5
    mean = model.mean
    if identity is not None:
        if not len(what):
            raise InputError("expected a morphable model with expressions to fit them alone, found one without")
        mean = mean + np.tensordot(identity, model.identity, 1)
        who = who[:0]
    space = MorphableModel(model.template, ShapeBases(mean, who, what, model.noise), model.albedo)
    fit = fit_landmarks_latent(points, space, spreads=spreads)
    prices = np.repeat((weights.identity, weights.expression), (len(who), len(what)))
    own = fit.face.require_latent() / np.sqrt(prices)
    latent = own if identity is None else np.concatenate([identity, own])
    face = replace(fit.face, latent=latent, model_id=model.model_id)
    return replace(fit, face=face, prior_rms=float(model.prior.rms(latent)))
