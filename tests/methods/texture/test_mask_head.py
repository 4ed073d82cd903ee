from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.texture.mask_head import mask_head, mesh_pixels


def moved(face, shift):
    return replace(face, camera=replace(face.camera, translation=face.camera.translation + shift))


def test_the_mesh_covers_the_pixels_that_show_it(pictured):
    pixels = mesh_pixels(pictured.face, pictured.image)
    assert pixels.shape == pictured.mask.shape
    np.testing.assert_array_equal(pixels, pictured.mask)


def test_the_head_is_cut_out_without_its_background(pictured):
    mask = mask_head(pictured.face, pictured.image)
    both, either = (mask & pictured.mask).sum(), (mask | pictured.mask).sum()
    assert mask.dtype == bool and both > 0.85 * either
    given = mask_head(replace(pictured.face, landmarks=None), pictured.image, pictured.face.landmarks)
    np.testing.assert_array_equal(given, mask)


@pytest.mark.parametrize("function", [mesh_pixels, mask_head])
def test_a_face_beside_the_picture_is_refused(function, pictured):
    with pytest.raises(InputError, match="expected the picture that the face was fitted to, found it outside"):
        function(moved(pictured.face, 5000), pictured.image)


def test_a_face_without_camera_or_landmarks_is_refused(pictured):
    with pytest.raises(InputError, match="expected a face with the camera"):
        mask_head(replace(pictured.face, camera=None), pictured.image)
    with pytest.raises(InputError, match="expected a face with fitted landmarks"):
        mask_head(replace(pictured.face, landmarks=None), pictured.image)
