from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.hair.face_size import face_size
from tests.methods.hair.conftest import CAMERA


def test_a_face_is_as_large_as_the_longer_side_of_its_68_landmarks_in_every_layout(sitter):
    points = CAMERA.project(sitter.head.vertices[sitter.head.annotation.landmarks])
    width, height = np.ptp(points[:68], axis=0)
    assert len(points) == 81 and face_size(sitter.face) == max(width, height)
    assert face_size(replace(sitter.face, landmarks=points)) == face_size(sitter.face)
    assert face_size(replace(sitter.face, landmarks=points[:, ::-1])) == face_size(sitter.face)
    assert face_size(replace(sitter.face, landmarks=0.01 * points[:68])) == 8


def test_a_face_without_landmarks_has_none(sitter):
    with pytest.raises(InputError, match="landmarks"):
        face_size(replace(sitter.face, landmarks=None))
