"""The face that shape models allow for lines, to follow them from."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np

from caricli.errors import InputError, NumericsError
from caricli.methods.faces.encode_landmarks import LandmarkEncoder
from caricli.methods.reconstruct.settings import IntrinsicSettings
from caricli.methods.sketch.fit_lines import Lines, fit_lines, line_camera
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.settings import COARSE, ELASTIC
from caricli.structures import Face
from caricli.structures.sketch import Sketch


class CoarseFace(NamedTuple):
    """A face that lines are followed from. face: Face with camera and latent. name: of COARSE, or ELASTIC."""

    face: Face
    name: str


def model_coarse(sketch: Sketch, lines: Lines, handles: LineHandles, encoder: LandmarkEncoder) -> CoarseFace:
    """A face that is likely for lines: inside the model, or an elastic one where the model has no face like that.

    A face of the model comes first (``fit_lines``). Where it leaves the lines by more than the model leaves usual
    faces, ``IntrinsicSettings.least``, the mean face is laid over the lines again, and where these have its landmarks
    the elastic fit takes it: so a drawing far from all faces keeps what the lines do not show usual.

    sketch: Sketch, not looked at. lines: of it, by curves. handles: LineHandles of the model's template.
    encoder: LandmarkEncoder of the model.
    Returns CoarseFace. Raises InputError where the lines tell too little.
    """
    model = encoder.model
    face = fit_lines(lines, handles, model)
    if misfit(face, lines, handles) <= IntrinsicSettings.least:
        return CoarseFace(face, COARSE[1])
    elastic = elastic_face(lines, handles, encoder)
    return CoarseFace(elastic, ELASTIC) if elastic else CoarseFace(face, COARSE[1])


def elastic_face(lines: Lines, handles: LineHandles, encoder: LandmarkEncoder) -> Face | None:
    """The elastic fit's face for lines by curves, over which the mean face is laid; None where they tell too little.

    handles: LineHandles of the model's template. encoder: LandmarkEncoder of the model. Returns Face with camera and
    latent.
    """
    model = encoder.model
    mean = model.decode_points(model.prior.mean, handles.vertices)
    # Lines that hold few landmarks tell of no other face.
    with suppress(InputError, NumericsError):
        places = handles.places(lines, line_camera(lines, handles, mean).project(mean))
        return encoder.encode(_landmarks(places, handles, model.template.annotation.landmarks))[0]
    return None


def misfit(face: Face, lines: Lines, handles: LineHandles) -> float:
    """Root mean square of the distances of a face's handles, which its camera sees, from their places along lines, as a
    share of the diagonal of these places.
    """
    own = face.require_camera().project(face.vertices[handles.vertices])
    places = handles.places(lines, own)
    met = np.isfinite(places).all(axis=1)
    if not met.any():
        return 0.0
    diagonal = np.linalg.norm(np.ptp(places[met], axis=0))
    return float(np.sqrt(((places[met] - own[met]) ** 2).sum(1).mean()) / diagonal)


def _landmarks(places: np.ndarray, handles: LineHandles, vertices: np.ndarray) -> np.ndarray:
    """(L, 2) pixels of the landmarks that stand on vertices (L,), NaN where no handle does, or nothing was drawn."""
    rows = np.searchsorted(handles.vertices, vertices).clip(max=len(handles.vertices) - 1)
    return np.where((handles.vertices[rows] == vertices)[:, None], places[rows], np.nan)
