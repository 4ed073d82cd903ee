import cv2
import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.stylise.paint_picture import LARGEST, PAINTERS, paint_picture
from caricli.methods.stylise.settings import STYLES
from caricli.structures import Landmarks
from tests.drawn_pictures import SIZE, drawn_picture, mean_shape


@pytest.fixture(scope="module")
def drawn(head_template):
    """A drawing of a face with what a camera's picture has besides, and its Landmarks."""
    picture = drawn_picture(mean_shape(head_template), np.random.default_rng(5))
    soft = cv2.GaussianBlur(picture.pixels, (0, 0), 1.5)
    light = np.linspace(0.6, 1.1, SIZE)[:, None, None]
    return np.clip(soft * light, 0, 255).astype(np.uint8), Landmarks(picture.landmarks[0], (SIZE, SIZE))


def painted(image, marks, style, seed=0):
    return paint_picture(image, marks, style, np.random.default_rng(seed))


def test_every_style_has_a_painter():
    assert set(STYLES) == {*PAINTERS, "none"}


@pytest.mark.parametrize("style", PAINTERS)
def test_the_same_seed_paints_the_same_and_the_picture_is_there(drawn, style):
    image, marks = drawn
    given = image.copy()
    first, again, other = (painted(image, marks, style, seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(image, given)
    assert first.shape == image.shape and first.dtype == np.uint8
    assert (first != image).any() and (style == "flat" or (first != other).any())
    grey = [cv2.GaussianBlur(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), (0, 0), 3) for picture in (image, first)]
    assert np.corrcoef(grey[0].ravel(), grey[1].ravel())[0, 1] > 0.5, "dark stays dark"


@pytest.mark.parametrize("style", PAINTERS)
def test_paint_is_as_large_as_the_face(drawn, style):
    """A larger picture is painted as the smaller one is, but for what is drawn at random."""
    image, marks = drawn
    large = cv2.resize(image, (2 * SIZE, 2 * SIZE), interpolation=cv2.INTER_CUBIC)
    larger = cv2.resize(image, (3 * SIZE, 3 * SIZE), interpolation=cv2.INTER_CUBIC)
    seen = [
        cv2.resize(painted(picture, Landmarks(factor * marks.points), style), (40, 40), interpolation=cv2.INTER_AREA)
        for factor, picture in ((2, large), (3, larger))
    ]
    assert np.abs(seen[0].astype(int) - seen[1]).mean() < 12


@pytest.mark.parametrize("style", PAINTERS)
@pytest.mark.parametrize("shape", [(1, 1), (3, 200), (90, 1)])
def test_pictures_of_any_form_are_painted(drawn, style, shape):
    image = np.full((*shape, 3), 200, np.uint8)
    assert painted(image, Landmarks(drawn[1].points), style).shape == image.shape


def test_large_pictures_are_painted_smaller_and_enlarged(drawn):
    image, marks = drawn
    factor = 2 * LARGEST / (marks.diagonal / 100)
    result = painted(cv2.resize(image, (400, 300)), Landmarks(factor * marks.points), "ink")
    assert result.shape == (300, 400, 3)


def test_without_a_style_pixels_stay_and_another_is_refused(drawn):
    image, marks = drawn
    assert painted(image, marks, "none") is image
    with pytest.raises(InputError, match="expected a style of oil, .* found crayon"):
        painted(image, marks, "crayon")
