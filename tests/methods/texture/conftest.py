"""A head that was fitted to a picture of it."""

from dataclasses import dataclass

import numpy as np
import pytest

from caricli.structures import Camera, Face, Pictures, Rig
from caricli.template.template import Template
from tests.drawn_albedo import soft_skin
from tests.textured_pictures import render_textured

SIDE = 240
MAGENTA = np.array([255.0, 0, 255])


@dataclass(frozen=True)
class Scene:
    """A head, the texture that it has, and its picture in front of magenta."""

    head: Template
    face: Face
    rig: Rig
    image: np.ndarray
    mask: np.ndarray


@pytest.fixture(scope="session")
def pictured(head, head_template):
    """A Scene of a person whom no model was trained on, seen from the front."""
    shape = head_template.with_vertices(head.evaluate(gender=0.3, age=0.6))
    camera = Camera(840.0, np.diag([1.0, -1.0, -1.0]), np.array([120.0, 232.0]))
    marks = camera.project(shape.vertices[shape.annotation.landmarks[:68]])
    skin = soft_skin(head_template)
    still = np.zeros((0, *shape.vertices.shape), np.float32)
    rig = Rig((), shape.with_vertices(shape.vertices.astype(np.float32)), still, pictures=Pictures(skin))
    image = render_textured(rig, camera.place(shape.vertices), SIDE, SIDE, paper=MAGENTA)
    return Scene(shape, Face(shape, camera, marks), rig, image, (image != MAGENTA).any(-1))
