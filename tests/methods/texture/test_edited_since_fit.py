from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.texture.edited_since_fit import edited_since_fit
from caricli.structures import Camera, Face

CAMERA = Camera(1000.0, np.diag([1.0, -1, -1]), np.array([150.0, 290.0]))


@pytest.mark.parametrize("count", [68, 81])
def test_the_farthest_landmark_counts_but_for_those_of_the_jaw(head_template, count):
    ids = head_template.annotation.landmarks[:count]
    face = Face(head_template, CAMERA, CAMERA.project(head_template.vertices[ids]))
    assert edited_since_fit(face, head_template) == pytest.approx(0, abs=1e-6)
    vertices = head_template.vertices.copy()
    vertices[ids[8]] += 0.05
    vertices[ids[30]] += [0.003, 0, 0]
    vertices[ids[33]] += [0.004, 0, 0]
    diagonal = np.linalg.norm(np.ptp(face.landmarks[:68], axis=0))
    assert edited_since_fit(face.with_vertices(vertices), head_template) == pytest.approx(4 / diagonal)


def test_a_face_without_landmarks_is_refused(head_template):
    with pytest.raises(InputError, match="expected a face with fitted landmarks"):
        edited_since_fit(replace(Face(head_template), camera=CAMERA), head_template)
