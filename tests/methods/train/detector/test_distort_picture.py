import numpy as np
import pytest

from caricli.methods.train.detector.distort_picture import DistortSettings, distort_picture, random_distortion
from caricli.structures.detection import FaceFrame, MarkedPicture
from caricli.structures.landmarks import EYE_RIGHT, LIPS, NOSE
from caricli.structures.parsing import BEYOND, Region
from tests.drawn_pictures import mean_shape

SIDE = 200
SETTINGS = DistortSettings()


@pytest.fixture(scope="module")
def landmarks(head_template):
    """(81, 2) a face of 100 pixels in the middle of the picture."""
    shape = mean_shape(head_template)
    shape = shape - (shape.min(0) + shape.max(0)) / 2
    return SIDE / 2 + 100 * shape / np.ptp(shape, axis=0).max()


@pytest.fixture
def picture(landmarks):
    """A black picture with a white dot at each landmark."""
    pixels = np.zeros((SIDE, SIDE, 3), np.uint8)
    columns, rows = np.rint(landmarks).astype(int).T
    for across in (-1, 0, 1):
        for down in (-1, 0, 1):
            pixels[rows + down, columns + across] = 255
    regions = np.where(pixels[..., 0] > 0, np.uint8(Region.SKIN), np.uint8(Region.BACKGROUND))
    return MarkedPicture(pixels, regions, landmarks[None], np.ones((1, len(landmarks)), bool))


def test_it_goes_there_and_back_without_folds(landmarks):
    grid = np.stack(np.meshgrid(np.arange(0.0, SIDE, 4), np.arange(0.0, SIDE, 4)), -1)
    sides = np.linalg.norm(np.ptp(landmarks, axis=0))
    moved = []
    for seed in range(60):
        distortion = random_distortion(landmarks, SETTINGS, np.random.default_rng(seed))
        places = distortion.places(grid)
        np.testing.assert_allclose(distortion.sources(places), grid, atol=1e-6)
        across = np.diff(places, axis=1)[:-1]
        down = np.diff(places, axis=0)[:, :-1]
        turned = FaceFrame.of(landmarks).roll
        assert abs(turned) < 1e-6
        assert (across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0] > 0).all(), seed
        moved.append(np.linalg.norm(distortion.places(landmarks) - landmarks, axis=1).mean() / sides)
    # As much as caricatures differ from one another: the mean shape is 7 to 10 % off.
    assert 0.04 < np.mean(moved) < 0.15


def test_parts_change_their_share_of_the_face(landmarks):
    settings = DistortSettings(heights=0, widths=0, aside=0)
    for part in (LIPS, NOSE, EYE_RIGHT):
        own = list(part)
        before = np.ptp(landmarks[own], axis=0)
        factors = []
        for seed in range(60):
            after = random_distortion(landmarks, settings, np.random.default_rng(seed)).places(landmarks)
            factors.append(np.ptp(after[own], axis=0) / before)
        across, down = np.transpose(factors)
        assert min(across) < 0.8 and max(across) > 1.3
        assert min(down) < 0.8 and max(down) > 1.3
        assert np.std(np.log(across / down)) > 0.1


def test_landmarks_and_regions_stay_on_what_they_mark(picture):
    seen = []
    for seed in range(20):
        out = distort_picture(picture, 0, SETTINGS, np.random.default_rng(seed))
        assert out.pixels.shape == picture.pixels.shape and out.visible.shape == picture.visible.shape
        columns, rows = np.rint(out.landmarks[0][out.visible[0]]).astype(int).T
        seen.append((out.pixels[rows, columns, 0] > 90).mean())
        assert (out.regions[out.pixels[..., 0] > 200] == Region.SKIN).mean() > 0.9
    assert np.mean(seen) > 0.97


def test_the_face_keeps_its_size_and_what_lies_beyond_is_unknown(picture):
    beyond = 0
    for seed in range(20):
        out = distort_picture(picture, 0, SETTINGS, np.random.default_rng(seed))
        assert FaceFrame.of(out.landmarks[0]).side == pytest.approx(FaceFrame.of(picture.landmarks[0]).side)
        outside = ((out.landmarks[0] < -0.5) | (out.landmarks[0] > SIDE - 0.5)).any(-1)
        assert not (out.visible[0] & outside).any()
        beyond += (out.regions == BEYOND).any()
    assert beyond > 3


def test_a_seed_gives_the_same_picture(picture):
    first, again = (distort_picture(picture, 0, SETTINGS, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(first.pixels, again.pixels)
    other = distort_picture(picture, 0, SETTINGS, np.random.default_rng(6))
    assert (first.pixels != other.pixels).any()
