"""A head, and cameras that see it."""

import numpy as np
import pytest

from caricli.render.views import turn_about_y
from caricli.structures import Camera, Face


@pytest.fixture(scope="session")
def face(head_template):
    return Face(head_template.with_vertices(head_template.vertices))


def view(degrees=0.0):
    """A camera that sees a head from a side, about 400 pixels high."""
    return Camera(1600.0, np.diag([1.0, -1, -1]) @ turn_about_y(degrees), np.array([210.0, 200.0]))


def ring(centre, radius, squeeze=1.0):
    turns = np.linspace(0, 2 * np.pi, 40)
    return centre + radius * np.stack([np.cos(turns), squeeze * np.sin(turns)], 1)


def mark(face, template, camera, number):
    """(2,) pixels of a landmark."""
    return camera.project(face.vertices[template.annotation.landmarks[number]])
