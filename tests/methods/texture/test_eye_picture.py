from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.texture.eye_picture import eye_picture
from caricli.render.eyes.paint_eye import IRIS
from caricli.render.eyes.place_eyeballs import place_eyeballs
from caricli.structures import Camera, Face
from caricli.template.head import load_head
from tests.render.eyes.test_iris_radius import eyes

RED = 190
"""Of 255: whites of eyes have more, and blue irises less."""


def reach(picture):
    """Half of the share of the width that iris and pupil have, across the middle."""
    return (picture[len(picture) // 2, :, 0] < RED).mean() / 2


@pytest.fixture(scope="module")
def head():
    return load_head().template()


def looked_at(head, radius):
    """The iris of a head whose eyes are as a picture's, 60 pixels wide, with irises of a radius in pixels."""
    image, marks = eyes(radius)
    ball = float(np.mean([each for _, each in place_eyeballs(head, head.annotation)]))
    # Eyeballs as large as openings are wide.
    camera = Camera(30 / ball, np.diag([1.0, -1.0, -1.0]), np.zeros(2))
    face = Face(head.with_vertices(head.vertices), camera=camera, landmarks=marks)
    return eye_picture(face, face.landmarks, head.annotation, image, np.random.default_rng(0))


def test_irises_are_as_large_as_the_picture_tells(head):
    small, large = (reach(looked_at(head, radius)) for radius in (10, 18))
    assert small < IRIS < large
    # The angle of an iris on its ball, as a share of the whole turn.
    assert abs(small - np.arcsin(10 / 30) / (2 * np.pi)) < 0.012
    assert abs(large - np.arcsin(18 / 30) / (2 * np.pi)) < 0.012


@pytest.mark.parametrize(("told", "most"), [(1.0, 0.7), (30.0, 1.5)])
def test_no_iris_is_a_dot_or_all_of_an_eye(head, monkeypatch, told, most):
    monkeypatch.setattr("caricli.methods.texture.eye_picture.iris_radius", lambda *_: (told, 1.0))
    assert reach(looked_at(head, 10)) == pytest.approx(most * IRIS, abs=0.004)


def test_a_picture_that_tells_nothing_leaves_the_usual_eye(head):
    image, marks = eyes(10)
    face = Face(head.with_vertices(head.vertices), camera=Camera(1000.0, np.eye(3), np.zeros(2)), landmarks=marks)
    away = replace(face, landmarks=marks + 1000)
    usual = eye_picture(away, away.landmarks, head.annotation, image, np.random.default_rng(0))
    assert abs(reach(usual) - IRIS) < 0.004
