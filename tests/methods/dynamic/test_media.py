import numpy as np
import pytest

from caricli.data.appearance import random_appearance
from caricli.methods.dynamic.lit_faces import LitFaces
from caricli.methods.dynamic.media import NAMES, NEAR_PAINTERS, OF_PICTURES, PAINTED, Medium, random_medium
from caricli.methods.pictures.light import random_sky
from caricli.methods.pictures.media import MEDIA


@pytest.fixture(scope="module")
def faces(head_template):
    return LitFaces(head_template, 96)


@pytest.fixture(scope="module")
def face(faces):
    generator = np.random.default_rng(3)
    return faces.draw(random_appearance(generator, "soft"), random_sky(generator))


def test_a_face_fills_its_picture_in_light_of_its_own(faces):
    appearance = random_appearance(np.random.default_rng(1), "soft")
    skies = [random_sky(np.random.default_rng(seed)) for seed in (1, 2)]
    pictures = [faces.draw(appearance, sky) for sky in skies]
    assert faces.painter.covered.mean() > 0.6
    np.testing.assert_array_equal(pictures[0], faces.draw(appearance, skies[0]))
    assert np.abs(pictures[0].astype(int) - pictures[1]).mean() > 3


@pytest.mark.parametrize("name", NAMES)
def test_the_same_medium_gives_the_same_bytes_and_changes_the_picture(face, name):
    medium = random_medium(np.random.default_rng(4), name)
    painted = medium.paint(face)
    assert painted.shape == face.shape and painted.dtype == np.uint8 and medium.name == name
    np.testing.assert_array_equal(painted, medium.paint(face.copy()))
    assert np.abs(painted.astype(int) - face).mean() > 1
    other = random_medium(np.random.default_rng(5), name).paint(face)
    assert (other != painted).any()


@pytest.mark.parametrize("name", NAMES)
def test_away_from_a_changed_mouth_all_strokes_stay(face, name):
    smiling = face.copy()
    smiling[62:74, 36:60] = (60, 8, 10)
    for seed in range(3):
        medium = random_medium(np.random.default_rng(seed), name)
        painted = [medium.paint(picture, face) for picture in (face, smiling)]
        off = np.abs(painted[0].astype(int) - painted[1]).max(2)
        assert off[:36].mean() < 0.2 and off[:36].max() <= 8
        assert off[62:74, 36:60].mean() > 2


@pytest.mark.parametrize("name", NEAR_PAINTERS)
def test_strokes_depend_on_nothing_far_from_them(face, name):
    dark = face.copy()
    dark[62:74, 36:60] = 20
    for seed in range(3):
        medium = random_medium(np.random.default_rng(seed), name)
        painted = [medium.paint(picture, face) for picture in (face, dark)]
        np.testing.assert_array_equal(painted[0][:44], painted[1][:44])


def test_pictures_need_not_be_square(face):
    for name in NAMES:
        assert random_medium(np.random.default_rng(0), name).paint(face[:50]).shape == (50, 96, 3)


@pytest.mark.parametrize("shape", [(96, 96), (50, 96), (96, 50), (300, 400)])
def test_strokes_are_as_large_as_the_shorter_side_of_a_picture_tells(monkeypatch, shape):
    canvases = []

    def paint(canvas):
        canvases.append(canvas)
        return canvas.image

    monkeypatch.setitem(NEAR_PAINTERS, "oil", paint)
    picture = np.full((*shape, 3), 51, np.uint8)
    assert (Medium("oil", 2.0, 0).paint(picture, 2 * picture) == picture).all()
    least = min(canvases[0].image.shape[:2])
    assert PAINTED <= least < PAINTED + min(shape)
    assert canvases[0].unit / least == pytest.approx(2 / PAINTED)
    assert (canvases[0].care == 1).all()
    np.testing.assert_allclose(canvases[0].image, 0.2, atol=1e-6)
    np.testing.assert_allclose(canvases[0].guide, 0.4, atol=1e-6)


@pytest.mark.parametrize("shape", [(300, 400), (400, 300)])
def test_media_of_pictures_see_the_border_go_on_beside_a_picture(monkeypatch, shape):
    squares = []

    def paint(square, *_):
        squares.append(square)
        return square

    monkeypatch.setitem(MEDIA, "flat", (paint, *MEDIA["flat"][1:]))
    picture = np.random.default_rng(0).integers(0, 256, (*shape, 3), np.uint8)
    assert (Medium("posterised", 2.0, 0).paint(picture) == picture).all()
    square = np.pad(picture, ((0, 400 - shape[0]), (0, 400 - shape[1]), (0, 0)), "edge")
    np.testing.assert_allclose(255 * squares[0], square, atol=1e-3)


def test_every_medium_of_pictures_has_one_name():
    assert sorted(OF_PICTURES.values()) == sorted(MEDIA)
    assert len(set(NAMES)) == len(NEAR_PAINTERS) + len(MEDIA)
