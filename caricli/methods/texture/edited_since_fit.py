"""How far a face is from where it was fitted in its picture."""

import numpy as np

from caricli.structures import Face
from caricli.structures.landmarks import COUNT, JAW
from caricli.template.template import Template

NOTICED = 0.01
"""Share of the landmarks' diagonal, from which on paint lies beside its place; a fit ends at 0."""


def edited_since_fit(face: Face, template: Template) -> float:
    """The largest distance of a landmark from where the fit left it, as a share of the landmarks' diagonal.

    The jaw's do not count, which slide along their paths. face: Face of the template's topology, with camera and
    landmarks. Raises InputError for one without.
    """
    fitted = face.require_landmarks()[:COUNT]
    now = face.require_camera().project(face.vertices[template.annotation.landmarks[:COUNT]])
    away = np.delete(np.linalg.norm(now - fitted, axis=1), JAW)
    return float(away.max() / np.linalg.norm(np.ptp(fitted, axis=0)))
