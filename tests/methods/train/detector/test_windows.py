import numpy as np
import pytest

from caricli.methods.train.detector.disguise_picture import disguise_window
from caricli.methods.train.detector.windows import WindowSettings, any_window, bent_places, face_window, random_bend
from caricli.structures.detection import FaceFrame
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT, MOUTH
from caricli.structures.parsing import BEYOND, Region
from tests.drawn_pictures import drawn_picture, mean_shape


@pytest.fixture(scope="module")
def picture(head_template):
    return drawn_picture(mean_shape(head_template), np.random.default_rng(5), faces=2)


def eyes_are_where_they_are_marked(window, face):
    """Whether what the window shows at the middle of marked eyes are eyes, where they are in it."""
    middles = np.array([face[list(part)].mean(0) for part in (EYE_LEFT, EYE_RIGHT)])
    cells = np.rint(middles).astype(int)
    inside = ((cells >= 0) & (cells < len(window.regions))).all(1)
    shown = window.regions[cells[inside, 1], cells[inside, 0]]
    return np.isin(shown, (Region.EYES, BEYOND)).all()


def eyes_are_near_their_marks(window, face):
    """The same within a pixel, of eyes that are not tiny: distorted, marks' mean is not where their middle goes."""
    eyes = [face[list(part)] for part in (EYE_LEFT, EYE_RIGHT)]
    middles = np.array([eye.mean(0) for eye in eyes if np.ptp(eye, axis=0).min() > 2]).reshape(-1, 2)
    cells = np.rint(middles).astype(int)
    inside = ((cells >= 1) & (cells < len(window.regions) - 1)).all(1)
    around = (window.regions[y - 1 : y + 2, x - 1 : x + 2] for x, y in cells[inside])
    return all(np.isin(shown, (Region.EYES, BEYOND)).any() for shown in around)


@pytest.mark.parametrize(
    ("settings", "are_kept"),
    [
        (WindowSettings(distorted=0), eyes_are_where_they_are_marked),
        (WindowSettings(distorted=1), eyes_are_near_their_marks),
    ],
    ids=["as it is", "distorted"],
)
@pytest.mark.parametrize("seed", range(12))
def test_marks_go_where_the_face_goes(picture, seed, settings, are_kept):
    window = face_window(picture, seed % 2, 64, settings, np.random.default_rng(seed))
    assert window.pixels.shape == (64, 64, 3) and window.regions.shape == (64, 64)
    assert window.landmarks.shape == (2, 81, 2)
    assert are_kept(window, window.landmarks[0])
    # In the picture right is left of left; mirrored, too.
    down = window.landmarks[0][MOUTH].mean(0) - window.landmarks[0][list(EYE_RIGHT)].mean(0)
    across = window.landmarks[0][list(EYE_LEFT)].mean(0) - window.landmarks[0][list(EYE_RIGHT)].mean(0)
    assert across[0] * down[1] - across[1] * down[0] > 0
    frame = FaceFrame.of(window.landmarks[0])
    assert 64 / 3.6 < frame.side < 64 / 1.1
    assert np.abs(frame.centre - 31.5).max() < 0.35 * frame.side


@pytest.mark.parametrize("seed", range(8))
def test_any_part_keeps_its_marks(picture, seed):
    window = any_window(picture, 128, WindowSettings(distorted=0), np.random.default_rng(seed))
    assert all(eyes_are_where_they_are_marked(window, face) for face in window.landmarks)
    distorted = any_window(picture, 128, WindowSettings(distorted=1), np.random.default_rng(seed))
    assert all(eyes_are_near_their_marks(distorted, face) for face in distorted.landmarks)


def test_a_mark_that_nobody_knows_stays_so_in_a_bent_window():
    bend = random_bend(64, 0.02, np.random.default_rng(0))
    points = np.array([[20.0, 30.0], [np.nan, np.nan]])
    bent = bent_places(points, bend)
    np.testing.assert_array_equal(bent, [bent_places(points[0], bend), points[1]])
    assert (bent[0] != points[0]).all()


def test_what_is_cut_off_is_not_visible(picture):
    settings = WindowSettings(cut=1.0, bent=0.0)
    hidden = 0
    for seed in range(8):
        window = face_window(picture, 0, 64, settings, np.random.default_rng(seed))
        cells = np.rint(window.landmarks[0]).astype(int)
        inside = ((cells >= 0) & (cells < 64)).all(1)
        beyond = window.regions[cells[inside, 1], cells[inside, 0]] == BEYOND
        assert (window.visible[0][inside] & beyond).mean() < 0.05, "but for rounding at the edge"
        hidden += (~window.visible[0]).sum()
    assert hidden > 0


def test_disguises_leave_marks_alone_but_for_what_they_cover(picture):
    for seed in range(40):
        window = face_window(picture, 0, 64, WindowSettings(), np.random.default_rng(seed))
        disguised = disguise_window(window, np.random.default_rng(seed))
        assert disguised.pixels.dtype == np.float32 and disguised.pixels.shape == (64, 64, 3)
        assert 0 <= disguised.pixels.min() and disguised.pixels.max() <= 1
        np.testing.assert_array_equal(disguised.landmarks, window.landmarks)
        covered = disguised.regions != window.regions
        assert (disguised.regions[covered] == Region.OTHER).all()
        assert (disguised.visible <= window.visible).all()
        again = disguise_window(window, np.random.default_rng(seed))
        np.testing.assert_array_equal(again.pixels, disguised.pixels)
