"""Where landmarks stand on a posed mesh."""

import numpy as np

from caricli.geometry.lines.slide_contour import slide_contour
from caricli.structures.landmarks import JAW
from caricli.template.template import Template


def landmark_vertices(vertices: np.ndarray, rotation: np.ndarray, template: Template, count: int) -> np.ndarray:
    """The vertices that the first landmarks stand on, those of the jaw on the outline of a posed face.

    vertices: (V, 3) metres. rotation: (3, 3) of the camera. template: Template with the annotation. count: landmarks.
    Returns (count,) vertex ids.
    """
    note = template.annotation
    jaw = slide_contour(vertices, rotation, template.vertices, note.landmarks[: len(JAW)], note.jaw_paths)
    return np.concatenate([jaw, note.landmarks[len(JAW) : count]])
