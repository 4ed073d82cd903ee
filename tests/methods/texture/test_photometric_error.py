from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.texture.estimate_light import Light
from caricli.methods.texture.photometric_error import photometric_error
from caricli.render.textured_colours import textured_colours
from caricli.structures import Pictures


def test_the_picture_of_a_head_is_that_of_its_texture(pictured):
    assert photometric_error(pictured.rig, pictured.face, pictured.image, pictured.mask) == 0


def test_colours_that_are_off_count_by_how_much_and_only_inside_the_mask(pictured):
    lighter = np.where(pictured.mask[..., None], np.minimum(pictured.image + 51, 255), pictured.image).astype(np.uint8)
    darker = replace(pictured.rig, pictures=Pictures(pictured.rig.pictures.skin // 2))
    error = photometric_error(pictured.rig, pictured.face, np.clip(pictured.image, 0, 204), pictured.mask)
    assert error < photometric_error(darker, pictured.face, pictured.image, pictured.mask) < 1
    plain = np.clip(pictured.image.astype(int) + 20, 0, 255)
    expected = np.abs(plain - pictured.image)[pictured.mask].mean() / 255
    found = photometric_error(pictured.rig, pictured.face, plain.astype(np.uint8), pictured.mask)
    assert found == pytest.approx(expected)
    beside = np.where(pictured.mask[..., None], pictured.image, 0).astype(np.uint8)
    assert photometric_error(pictured.rig, pictured.face, beside, pictured.mask) == 0
    assert photometric_error(pictured.rig, pictured.face, lighter, pictured.mask) > 0


def test_light_is_put_back_before_anything_is_rounded(pictured):
    light = Light(np.eye(9, 1) * [4.0, 3.5, 4.5], np.tile([[0.1], [9.0]], 3), 1.0)
    height, width = pictured.mask.shape
    placed = pictured.face.require_camera().place(pictured.face.vertices)
    unlit = textured_colours(pictured.rig, placed, width, height)
    lit = np.minimum(unlit * light.shade(np.array([[0.0, 0, 1]])), 255)
    image = np.where(pictured.mask[..., None], np.round(lit), pictured.image).astype(np.uint8)
    assert photometric_error(pictured.rig, pictured.face, image, pictured.mask, light) < 1e-5
    assert photometric_error(pictured.rig, pictured.face, image, pictured.mask) > 0.03


def test_a_head_that_its_mask_does_not_show_is_refused(pictured):
    with pytest.raises(InputError, match="expected a mask that shows skin of the head, found none of it there"):
        photometric_error(pictured.rig, pictured.face, pictured.image, np.zeros_like(pictured.mask))
