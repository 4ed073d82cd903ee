"""A face of the morphable model from 2D landmarks: the coarse geometry of the portrait paper."""

from dataclasses import replace

import numpy as np

from caricli.methods.reconstruct.fit_landmarks import LatentSettings, fit_landmarks_latent
from caricli.models.pca.model import PcaModel

WEIGHTS = (1.2, 1.0)
"""Of identity and expression in equation 6; their common scale is that of ``LatentSettings.noise``."""


def fit_morphable(points, model, weights=WEIGHTS, identity=None):
    """Fit identity, expression and pose (equations 7 and 8, squared, with the regularisation of equation 6).

    Minimises ``sum_n w_n |q_n - p_n|^2 / noise^2 + weights[0] |identity|^2 + weights[1] |expression|^2`` over the pose
    and both coefficients by ``fit_landmarks_latent``; distances are shares of the landmarks' diagonal.

    points: (L, 2) pixels, y down, NaN where unknown. model: MorphableModel. weights: of identity and expression, above
    zero. identity: (I,) coefficients that stay as they are ("Adjust Exp"), or None to fit them too.
    Returns LandmarkFit; its latent is the model's. Raises InputError, NumericsError.
    """
    who, what = model.identity / weights[0] ** 0.5, model.expression / weights[1] ** 0.5
    if identity is None:
        space = PcaModel(model.template, model.mean, np.concatenate([who, what]))
    else:
        space = PcaModel(model.template, model.mean + np.tensordot(identity, model.identity, 1), what)
    fit = fit_landmarks_latent(points, space, LatentSettings())
    fitted = fit.latent / np.sqrt(np.repeat(weights, (len(who), len(what))))[-len(fit.latent) :]
    latent = fitted if identity is None else np.concatenate([identity, fitted])
    return replace(fit, latent=latent, prior_rms=float(model.prior.rms(latent)))
