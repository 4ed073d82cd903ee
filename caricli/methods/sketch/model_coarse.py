"""The face that shape models allow for lines, to follow them from."""

from contextlib import suppress

import numpy as np

from caricli.errors import InputError, NumericsError
from caricli.methods.faces.encode_landmarks import LandmarkEncoder
from caricli.methods.reconstruct.settings import IntrinsicSettings
from caricli.methods.sketch.fit_lines import Lines, fit_lines, line_camera
from caricli.methods.sketch.line_handles import LineHandles
from caricli.structures import Face
from caricli.structures.sketch import Sketch


def model_coarse(sketch: Sketch, lines: Lines, handles: LineHandles, encoder: LandmarkEncoder) -> Face:
    """A face that is likely for lines: inside the model, or an elastic one where the model has no face like that.

    A face of the model comes first (``fit_lines``). Where it leaves the lines by more than the model leaves usual
    faces, ``IntrinsicSettings.least``, the mean face is laid over the lines again, and where these have its landmarks
    the elastic fit takes it: so a drawing far from all faces keeps what the lines do not show usual.

    sketch: Sketch, not looked at. lines: of it, by curves. handles: LineHandles of the model's template.
    encoder: LandmarkEncoder of the model.
    Returns Face with camera and latent. Raises InputError where the lines tell too little.
    """
    model = encoder.model
    face = fit_lines(lines, handles, model)
    own = face.require_camera().project(face.vertices[handles.vertices])
    if _misfit(handles.places(lines, own), own) <= IntrinsicSettings.least:
        return face
    mean = model.decode_points(model.prior.mean, handles.vertices)
    places = handles.places(lines, line_camera(lines, handles, mean).project(mean))
    # Lines that hold few landmarks tell of no other face.
    with suppress(InputError, NumericsError):
        return encoder.encode(_landmarks(places, handles, model.template.annotation.landmarks))[0]
    return face


def _misfit(places: np.ndarray, own: np.ndarray) -> float:
    """Root mean square of the distances of handles (H, 2) from their places (H, 2), of the diagonal of these."""
    met = np.isfinite(places).all(axis=1)
    if not met.any():
        return 0.0
    diagonal = np.linalg.norm(np.ptp(places[met], axis=0))
    return float(np.sqrt(((places[met] - own[met]) ** 2).sum(1).mean()) / diagonal)


def _landmarks(places: np.ndarray, handles: LineHandles, vertices: np.ndarray) -> np.ndarray:
    """(L, 2) pixels of the landmarks that stand on vertices (L,), NaN where no handle does, or nothing was drawn."""
    rows = np.searchsorted(handles.vertices, vertices).clip(max=len(handles.vertices) - 1)
    return np.where((handles.vertices[rows] == vertices)[:, None], places[rows], np.nan)
