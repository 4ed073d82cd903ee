"""The fits of faces to landmarks that commands offer, each as the FitTask of its command."""

from collections.abc import Callable
from dataclasses import astuple
from functools import partial
from pathlib import Path
from typing import Any

from caricli.commands.shared.landmark_batch import FitTask, LandmarkFiles
from caricli.commands.shared.notes import echo_notes
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.methods.reconstruct.settings import MorphableWeights
from caricli.store.models import DEFAULT_ELASTIC, DEFAULT_LATENT, load_model, load_morphable
from caricli.structures.detection import FacePicture


def elastic_task(
    files: LandmarkFiles,
    model: Path | None = None,
    method: str | None = None,
    prior_weight: float = 1.0,
    outline: str = "auto",
) -> FitTask:
    """What `reconstruct-from-landmarks` does. model, method, prior_weight, outline: its options."""
    from caricli.methods.reconstruct.fit_landmarks import fit_landmarks, fitting_method

    shape_model = load_model(model, DEFAULT_LATENT if method == "latent" else DEFAULT_ELASTIC)
    method = method or fitting_method(shape_model)
    shape_model.prepare()
    # Edits go on in the model that is the best for them, unless another one was asked for.
    latents = load_model(kind=DEFAULT_LATENT) if model is None and method == "intrinsic" else None
    looks = outline == "auto"

    def fit(picture: FacePicture) -> LandmarkFit:
        marks = picture.landmarks
        shown = picture.parsed if looks else None
        return fit_landmarks(marks.head_points, shape_model, method, prior_weight, shown, marks.spreads)

    about = {"method": method, "prior_weight": prior_weight, "outline": outline, "model_id": shape_model.model_id}
    return FitTask(
        "reconstruct-from-landmarks", files, shape_model, 0, fit, about, [model], latents=latents, parses=looks
    )


def morphable_task(
    files: LandmarkFiles,
    model: Path | None = None,
    weights: MorphableWeights = MorphableWeights(),  # noqa: B008 (frozen)
    expression_only: bool = False,
    identity: Path | None = None,
    photometric: bool = False,
) -> FitTask:
    """What `fit-morphable` does. model, weights, expression_only, identity, photometric: its options."""
    from caricli.store.faces import load_identity, load_worn_face

    if photometric:
        from caricli.methods.morphable.fit_photometric import fit_photometric as fitting
    else:
        from caricli.methods.reconstruct.fit_morphable import fit_morphable

        fitting = _of_marks(fit_morphable)
    shape_model = load_morphable(model)
    kept, note = load_identity(identity, shape_model) if expression_only else (None, None)
    echo_notes(note)
    fit = partial(fitting, model=shape_model, weights=weights, identity=kept)
    about = {"model_id": shape_model.model_id, "weights": astuple(weights), "expression_only": expression_only}
    about["photometric"] = photometric
    worn = None if identity is None or photometric else load_worn_face(identity, shape_model)
    return FitTask("fit-morphable", files, shape_model, 0, fit, about, [model], [identity], worn=worn)


def network_task(
    files: LandmarkFiles, model: Path | None = None, network: Path | None = None, alone: bool = False
) -> FitTask:
    """What `fit-coarse` does. model, network, alone: its options."""
    from caricli.methods.reconstruct.fit_coarse import fit_coarse
    from caricli.store.coarse import load_coarse_pair

    teller, shape_model = load_coarse_pair(network, model)

    def fit(picture: FacePicture) -> LandmarkFit:
        marks = picture.landmarks
        return fit_coarse(marks.head_points, shape_model, teller, picture.pixels, alone, marks.spreads)

    about = {"model_id": shape_model.model_id, "network_id": teller.model_id, "alone": alone}
    return FitTask("fit-coarse", files, shape_model, 0, fit, about, [model, network])


def _of_marks(fitting: Callable[..., LandmarkFit]) -> Callable[..., LandmarkFit]:
    """The fit to a FacePicture that is one to its landmarks alone."""

    def fit(picture: FacePicture, **options: Any) -> LandmarkFit:
        return fitting(picture.landmarks.head_points, spreads=picture.landmarks.spreads, **options)

    return fit


COARSE_TASKS: dict[str, Callable[..., FitTask]] = {
    "elastic": elastic_task,
    "network": network_task,
    "morphable": morphable_task,
}
"""By what `portrait --coarse` calls them, COARSE."""
