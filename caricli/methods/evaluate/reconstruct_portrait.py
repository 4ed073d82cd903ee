"""One portrait, coarse and refined, by every method (portrait paper, section 4.2)."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from caricli.errors import CaricliError
from caricli.geometry.alignment.similarity import similarity
from caricli.methods.evaluate.portrait_studio import Portrait
from caricli.methods.morphable.fit_photometric import fit_photometric
from caricli.methods.reconstruct.fit_coarse import fit_coarse
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.methods.reconstruct.refine_face import refine_face
from caricli.methods.reconstruct.settings import MorphableWeights
from caricli.structures import Face
from caricli.structures.landmarks import PARTS
from caricli.template.template import Template

COARSE = {
    "morphable": "morphable",
    "photometric": "morphable",
    "network": "morphable",
    "elastic": "intrinsic",
    "deformable": "deformable",
}
"""Coarse methods by name: the kind of their model."""

NETWORK = "coarse network"
"""By what the network of the method "network" goes among the models."""

REFINED = " + refine"
ADJUSTED = ("adjust exp", "adjust id+exp")
METHODS = (*(f"{name}{end}" for name in COARSE for end in ("", REFINED)), *ADJUSTED)

PAPER_SIDE = 224
"""Pixels of the pictures that the paper's network takes."""

UNBOUND = MorphableWeights(MorphableWeights().identity / 100, MorphableWeights().expression / 100)
"""Of equation 7, which has no regularisation: a hundredth of that of equation 6 keeps it solvable."""


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """A face found in a portrait.

    face: Face with the portrait's camera and the landmarks where they project to.
    errors: mean distances to the given landmarks by part and "all", in percent of their diagonal.
    flipped: share of triangles that are turned over.
    seconds: a refinement's with those of what it refines.
    """

    face: Face
    errors: dict[str, float]
    flipped: float
    seconds: float


def reconstruct_portrait(
    portrait: Portrait, models: Mapping[str, Any]
) -> tuple[dict[str, Reconstruction], dict[str, str]]:
    """Reconstruct a face by every one of METHODS.

    "photometric" are equations 3 to 6; "network" is the CoarseModel trained with them, brought to the landmarks;
    "adjust exp" and "adjust id+exp" are equation 7, the former with the mean identity. All others take the landmarks
    alone.

    models: ShapeModels by kind, and the CoarseModel by NETWORK.
    Returns Reconstructions by METHODS, and of those that refused the landmarks what they said.
    Raises InputError, NumericsError.
    """
    points = portrait.points
    reconstructions = {}
    refused = {}
    for name, kind in COARSE.items():
        coarse = _timed(partial(_coarse, name, portrait, models), models[kind].template)
        reconstructions[name] = coarse
        start = time.perf_counter()
        try:
            fine = refine_face(coarse.face, points, models[kind].template)
        except CaricliError as error:
            refused[name + REFINED] = str(error)
            continue
        seconds = coarse.seconds + time.perf_counter() - start
        reconstructions[name + REFINED] = Reconstruction(fine.face, fine.after, fine.flipped, seconds)
    morphable = models["morphable"]
    for name, identity in zip(ADJUSTED, (np.zeros(len(morphable.identity)), None), strict=True):
        fitting = partial(fit_morphable, points, morphable, UNBOUND, identity)
        reconstructions[name] = _timed(fitting, morphable.template)
    return reconstructions, refused


def _coarse(name: str, portrait: Portrait, models: Mapping[str, Any]) -> LandmarkFit:
    """The fit to a portrait by one of COARSE."""
    model = models[COARSE[name]]
    if name == "photometric":
        return fit_photometric(portrait.picture, model)
    if name == "network":
        return fit_coarse(portrait.points, model, models[NETWORK], portrait.image)
    return fit_morphable(portrait.points, model) if name == "morphable" else fit_landmarks(portrait.points, model)


def _timed(fitting: Callable[[], LandmarkFit], template: Template) -> Reconstruction:
    """The Reconstruction that a function's fit is, without what the model says of it."""
    start = time.perf_counter()
    fit = fitting()
    seconds = time.perf_counter() - start
    face = Face(template.with_vertices(fit.face.vertices), fit.face.camera, fit.face.landmarks)
    return Reconstruction(face, fit.part_errors | {"all": fit.nme}, fit.flipped, seconds)


def measure_portrait(reconstruction: Reconstruction, portrait: Portrait, template: Template) -> dict:
    """Figures of a Reconstruction, as JSON.

    nme: its errors. pixels: the paper's sum of distances in a picture of PAPER_SIDE pixels. shape, where the truth is
    known: mean distance of the vertices of the face after a similarity alignment of them, in percent of the head's
    height. flipped: percent of triangles. seconds.
    """
    given = np.isfinite(portrait.points).all(1)
    diagonal = np.linalg.norm(np.ptp(portrait.points[given], axis=0))
    scale = diagonal / 100 * PAPER_SIDE / max(portrait.image.shape[:2])
    counts = {name: given[[k for k in ids if k < len(given)]].sum() for name, ids in PARTS.items()}
    counts["all"] = given.sum()
    figures = {
        "nme": reconstruction.errors,
        "pixels": {name: float(scale * counts[name] * error) for name, error in reconstruction.errors.items()},
        "flipped": 100 * reconstruction.flipped,
        "seconds": reconstruction.seconds,
    }
    if portrait.truth is not None:
        figures["shape"] = shape_error(reconstruction.face.vertices, portrait.truth, template)
    return figures


def shape_error(vertices: np.ndarray, truth: np.ndarray, template: Template) -> float:
    """Mean distance (V, 3) of the face after alignment, in percent of the true head's height."""
    region = template.region("face")
    ours = vertices[region]
    true = truth[region]
    scale, rotation, translation = similarity(ours, true)
    distances = np.linalg.norm(scale * ours @ rotation.T + translation - true, axis=1)
    return float(100 * distances.mean() / np.ptp(truth[:, 1]))
