"""A face of the morphable model from landmarks and the colours of a picture (portrait paper, equations 3 to 6)."""

from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.errors import InputError
from caricli.methods.morphable.photometric_search import PhotometricSearch
from caricli.methods.morphable.picture_window import PictureWindow
from caricli.methods.morphable.settings import PhotometricSettings
from caricli.methods.morphable.skin_pixels import skin_pixels
from caricli.methods.morphable.wear_colours import wear_colours
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.landmark_fit import LandmarkFit, Observation
from caricli.methods.reconstruct.settings import LatentSettings, MorphableWeights
from caricli.models.morphable.model import MorphableModel
from caricli.structures.detection import FacePicture

_SETTINGS = PhotometricSettings()


@dataclass(frozen=True, eq=False, kw_only=True)
class PhotometricFit(LandmarkFit):
    """A LandmarkFit whose colours were fitted too.

    coefficients: by the names of CoefficientLayout, pose in pixels of the given picture. before, after: root mean
    square differences to the picture's colours, percent of full scale, over what is compared.
    """

    coefficients: dict[str, np.ndarray]
    before: float
    after: float

    def figures(self) -> dict[str, Any]:
        """What reports say of the fit, as JSON."""
        differences = {"before": self.before, "after": self.after}
        own = {"photometric": differences | asdict(_SETTINGS), "coefficients": self.coefficients}
        return super().figures() | own

    def describe(self) -> str:
        """What is printed of it."""
        return f"{super().describe()}, colours {self.before:.1f} to {self.after:.1f} % off"


@threadpool_limits.wrap(limits=1)
def fit_photometric(
    picture: FacePicture,
    model: MorphableModel,
    weights: MorphableWeights = MorphableWeights(),  # noqa: B008 (frozen)
    identity: np.ndarray | None = None,
) -> PhotometricFit:
    """Fit identity, expression, colours, light and pose to landmarks and a picture (equations 3 to 6).

    To what ``fit_morphable`` minimises it adds ``photometric * |A (I_render - I)|^2 / |A| + albedo * |c|^2`` for the
    colours' coefficients c, and goes on from there by damped Gauss-Newton steps on all coefficients. A holds how surely
    a pixel shows bare skin of the face, by the parsed picture or else by the fitted face alone; the farther its colour
    is off, the less it counts (Geman and McClure).

    weights, identity: see ``fit_morphable``.
    Returns PhotometricFit, whose face wears the colours without the light. Raises InputError, NumericsError.
    """
    if picture.pixels is None:
        raise InputError("expected a picture whose colours can be fitted, found landmarks alone: give it with --image")
    points = picture.landmarks.head_points
    spreads = picture.landmarks.spreads
    start = fit_morphable(points, model, weights, identity, spreads)
    observation = Observation(points, model.template, spreads=spreads)
    marks = observation.points * observation.diagonal + observation.centre
    window = PictureWindow(picture.pixels, marks, _SETTINGS.diagonal, _SETTINGS.margin)
    if picture.regions is not None:
        window.trust(skin_pixels(picture.regions))
    search = PhotometricSearch(model, observation, window, _SETTINGS)
    search.begin(start.face)
    before = search.difference()
    free = np.ones(len(search.x), bool)
    search.layout.parts(free)["identity"][:] = identity is None
    search.run(_prices(search, weights), free)
    return _finished(search, observation, start, before)


def _prices(search: PhotometricSearch, weights: MorphableWeights) -> np.ndarray:
    """(D,) of the squared coefficients."""
    prices = np.zeros(len(search.x))
    parts = search.layout.parts(prices)
    parts["identity"][:] = weights.identity
    parts["expression"][:] = weights.expression
    parts["albedo"][:] = _SETTINGS.albedo
    parts["light"][:] = _SETTINGS.light
    return prices


def _finished(search: PhotometricSearch, observation: Observation, start: LandmarkFit, before: float) -> PhotometricFit:
    model = search.renderer.model
    latent = search.x[: search.layout.shape]
    camera = observation.in_units(search.camera())
    face = replace(start.face, mesh=model.template.with_vertices(model.decode(latent)), latent=latent, camera=camera)
    fit = observation.measure(face, model, search.trust, LatentSettings(), camera)
    coefficients = search.x.copy()
    pose = search.layout.parts(coefficients)["pose"]
    pose[3:5] = search.window.to_picture(pose[3:5])
    pose[5] /= search.window.zoom
    colours = model.colours(search.layout.parts(search.x)["albedo"])
    own = {field.name: getattr(fit, field.name) for field in fields(LandmarkFit)}
    own |= {"face": wear_colours(fit.face, model.template, colours), "rounds": start.rounds}
    named = search.layout.report(coefficients)
    return PhotometricFit(**own, coefficients=named, before=100 * before, after=100 * search.difference())
