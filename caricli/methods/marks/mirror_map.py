"""What a move of one side of a face is on the other side, as its picture shows both."""

import numpy as np

from caricli.errors import NumericsError
from caricli.geometry.alignment.fit_camera import fit_camera
from caricli.structures.landmarks import FEWEST, JAW
from caricli.template.template import Template

_TURNED = 0.25  # of the frontal plane's area, as the picture shows it: about 75 degrees from the front


def mirror_map(points: np.ndarray, template: Template) -> np.ndarray:
    """The map of moves in the picture to those of their mirror images on the face.

    The camera that sees the template's landmarks nearest to the points tells how the face is turned. A move is taken to
    be within the frontal plane of the face, where mirroring turns x round: ``A diag(-1, 1) A^-1``, A the first two
    columns of the camera's first two rows. For a face seen from the front that is the reflection in its own axis,
    however it leans; of a turned one it is that reflection as the picture shows it.

    points: (L, 2) pixels, y down, NaN where unknown. The jaw counts only where too few others are known, because its
    points slide as a head turns. template: with those landmarks.
    Returns (2, 2), its own inverse. Raises NumericsError where the points tell no pose, or one from the side.
    """
    given = np.isfinite(points).all(axis=1)
    inner = given & ~np.isin(np.arange(len(points)), JAW)
    chosen = inner if inner.sum() >= FEWEST else given
    places = template.vertices[template.annotation.landmarks[: len(points)]]
    plane = fit_camera(places[chosen], points[chosen]).rotation[:2, :2]
    if abs(np.linalg.det(plane)) < _TURNED:
        raise NumericsError("the face is seen from the side, where one half does not tell how the other moves")
    return plane @ np.diag([-1.0, 1.0]) @ np.linalg.inv(plane)
