"""A 3D face from 2D landmarks by the method of a name."""

from dataclasses import replace
from typing import cast

import numpy as np

from caricli.errors import InputError
from caricli.methods.reconstruct.fit_landmarks_intrinsic import fit_landmarks_intrinsic
from caricli.methods.reconstruct.fit_landmarks_latent import fit_landmarks_latent
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.methods.reconstruct.settings import METHODS, IntrinsicSettings, LatentSettings
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.shape_model import ShapeModel


def fitting_method(model: ShapeModel) -> str:
    """The better of METHODS of those that a model allows."""
    return METHODS[0] if model.kind == "intrinsic" else METHODS[1]


def fit_landmarks(
    points: np.ndarray, model: ShapeModel, method: str | None = None, prior_weight: float = 1.0
) -> LandmarkFit:
    """Fit a face elastically, or inside the model.

    points: (L, 2) pixels, y down, NaN where unknown. model: ShapeModel, for "intrinsic" an IntrinsicModel. method: of
    METHODS, or None for the one that the model allows, see ``fitting_method``. prior_weight: larger stays nearer to
    plausible faces, smaller nearer to the landmarks.
    Returns LandmarkFit. Raises InputError, NumericsError.
    """
    if (method or fitting_method(model)) == "latent":
        return fit_landmarks_latent(points, model, LatentSettings(noise=LatentSettings.noise * prior_weight**0.5))
    if model.kind != "intrinsic":
        raise InputError(
            f"the method 'intrinsic' needs an intrinsic model, found one of kind {model.kind!r}; give --method latent"
        )
    usual = IntrinsicSettings()
    factor = prior_weight**0.5
    settings = replace(usual, misfit=usual.misfit * factor, least=usual.least * factor)
    return fit_landmarks_intrinsic(points, cast(IntrinsicModel, model), settings)
