"""A 3D face from 2D landmarks by the method of a name."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from caricli.errors import InputError
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.reconstruct.fit_landmarks_intrinsic import fit_landmarks_intrinsic
from caricli.methods.reconstruct.fit_landmarks_latent import fit_landmarks_latent
from caricli.methods.reconstruct.landmark_fit import LandmarkFit, landmark_errors
from caricli.methods.reconstruct.outline import Outline, can_find_outline
from caricli.methods.reconstruct.settings import METHODS, IntrinsicSettings, LatentSettings
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import COUNT
from caricli.template.template import Template

_SEED = 0  # of the search in the picture: the same picture gives the same face


def fitting_method(model: ShapeModel) -> str:
    """The better of METHODS of those that a model allows."""
    return METHODS[0] if model.kind == "intrinsic" else METHODS[1]


def fit_landmarks(
    points: np.ndarray,
    model: ShapeModel,
    method: str | None = None,
    prior_weight: float = 1.0,
    picture: ParsedPicture | None = None,
    spreads: np.ndarray | None = None,
) -> LandmarkFit:
    """Fit a face elastically, or inside the model.

    Where 68 landmarks come with a picture, ears and forehead that are seen there pull weakly (``find_outline``); where
    further ones were detected, ears that stand out there count beside them. A face that is fitted elastically gets the
    outline of ears (``fit_ears``), a neck as thin (``fit_neck``) and sides as far in (``fit_sides``) as the picture
    shows them.

    points: (L, 2) pixels, y down, NaN where unknown. model: ShapeModel, for "intrinsic" an IntrinsicModel. method: of
    METHODS, or None for the one that the model allows, see ``fitting_method``. prior_weight: larger stays nearer to
    plausible faces, smaller nearer to the landmarks. picture: ParsedPicture that they belong to, or None to look at
    none. spreads: (L, 2, 2) covariances of the points' errors, square pixels, or None where nothing is known of them.
    Returns LandmarkFit. Raises InputError, NumericsError.
    """
    look = None
    if picture is not None and can_find_outline(points, model.template, spreads):
        look = partial(_look, template=model.template, points=points, picture=picture)
    fit = _method(model, method or fitting_method(model), prior_weight)(points, look=look, spreads=spreads)
    if picture is None or fit.face.residual is None:
        return fit
    if spreads is not None and fit.outline is not None:
        points, _ = fit.outline.joined(points, spreads)
    return _as_pictured(fit, points, cast(IntrinsicModel, model), picture)


def _look(face: Face, template: Template, points: np.ndarray, picture: ParsedPicture) -> Outline:
    """What is found in a picture around a face that fits landmarks (L, 2)."""
    # OpenCV takes a while to start, and most fits have no picture.
    from caricli.methods.reconstruct.find_outline import find_outline

    outline = find_outline(face, template, points[:COUNT], picture, np.random.default_rng(_SEED))
    return outline if len(points) == COUNT else outline.sure_ears


def _as_pictured(fit: LandmarkFit, points: np.ndarray, model: IntrinsicModel, picture: ParsedPicture) -> LandmarkFit:
    """A fit whose ears and sides end where a picture shows it, and whose neck is as thin.

    points: (L, 2) landmarks that were fitted. model: of its latent.
    """
    # OpenCV takes a while to start, and most fits have no picture.
    from caricli.methods.reconstruct.fit_ears import fit_ears
    from caricli.methods.reconstruct.fit_neck import fit_neck
    from caricli.methods.reconstruct.fit_sides import fit_sides

    template = model.template
    seen, neck = fit_neck(fit_ears(fit.face, template, picture), template, picture)
    seen = fit_sides(seen, template, picture, fit.anchors)
    if seen is fit.face:
        return fit
    vertices = template.mended(seen.vertices)
    residual = template.gradients.features(vertices) - model.features(seen.require_latent())
    landmarks = seen.require_camera().project(vertices[fit.anchors])
    nme, part_errors = landmark_errors(landmarks, points)
    face = replace(seen.with_vertices(vertices), landmarks=landmarks, residual=residual)
    flipped = float(flipped_triangles(vertices, template.gradients).mean())
    return replace(fit, face=face, nme=nme, part_errors=part_errors, flipped=flipped, neck=neck)


def _method(model: ShapeModel, method: str, prior_weight: float) -> Callable[..., LandmarkFit]:
    """The function of a name, with model and settings. Raises InputError where the model cannot do it."""
    if method not in METHODS:
        raise InputError(f"expected a method of {', '.join(METHODS)}, found {method!r}")
    factor = prior_weight**0.5
    if method == "latent":
        return partial(fit_landmarks_latent, model=model, settings=LatentSettings(noise=LatentSettings.noise * factor))
    if model.kind != "intrinsic":
        raise InputError(
            f"the method 'intrinsic' needs an intrinsic model, found one of kind {model.kind!r}, which 'latent' fits"
        )
    usual = IntrinsicSettings()
    settings = replace(
        usual, misfit=usual.misfit * factor, least=usual.least * factor, follow=usual.follow * prior_weight
    )
    return partial(fit_landmarks_intrinsic, model=cast(IntrinsicModel, model), settings=settings)
