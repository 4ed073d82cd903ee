import cv2
import numpy as np
import pytest

from caricli.methods.texture.grow_grain import grow_grain

SIDE = 256
SKIN = np.array([200.0, 150, 120])
DARK = np.array([80.0, 60, 48])


def noise(generator):
    """(S, S, 1) blotches of some texels, of standard deviation 0.04."""
    blotches = cv2.GaussianBlur(generator.normal(size=(SIDE, SIDE)), (0, 0), 1.2)
    return 0.04 * (blotches / blotches.std())[..., None]


@pytest.fixture(scope="module")
def skin():
    """A texture with grain on its left half, smooth on its right one, which is darker."""
    left = np.arange(SIDE) < SIDE // 2
    image = np.where(left[None, :, None], SKIN * (1 + noise(np.random.default_rng(0))), DARK)
    return image, np.broadcast_to(left.astype(float), (SIDE, SIDE)), np.ones((SIDE, SIDE), int)


def grown(skin, seed=0, regions=None):
    image, seen, everywhere = skin
    return grow_grain(image, seen, everywhere if regions is None else regions, np.random.default_rng(seed))


def fine(image):
    """What is finer than two texels and a half, relative to the colour."""
    image = image.astype(np.float64)
    return (image / cv2.GaussianBlur(image, (0, 0), 2.5) - 1)[16:-16, SIDE // 2 + 16 : -16]


def test_what_is_not_seen_gets_the_same_grain_in_its_own_colour(skin):
    image, seen, _ = skin
    result = grown(skin)
    unseen = result[:, SIDE // 2 + 8 :]
    np.testing.assert_allclose(unseen.mean((0, 1)), DARK, rtol=0.01)
    strength = fine(result).std() / fine(image[:, ::-1]).std()
    assert 0.6 < strength < 1.2
    np.testing.assert_allclose(result[seen == 1], image[seen == 1], rtol=1e-6)


def test_grain_does_not_repeat(skin):
    """No piece of a patch's width is anywhere again a patch farther on."""
    piece = fine(grown(skin))[..., 0].astype(np.float32)
    alike = cv2.matchTemplate(piece, piece[40:56, 30:46], cv2.TM_CCOEFF_NORMED)
    assert alike.max() == pytest.approx(1, abs=1e-3) and (alike > 0.95).sum() <= 2


def test_the_same_seed_gives_the_same_grain(skin):
    np.testing.assert_array_equal(grown(skin), grown(skin))
    assert np.abs(grown(skin) - grown(skin, seed=1)).max() > 1


def test_strong_marks_are_no_grain(skin):
    image, seen, everywhere = skin
    marked = image.copy()
    marked[20:200, 20:100] *= 1 + 0.25 * (np.indices((180, 80)).sum(0) % 8 < 4)[..., None]
    assert np.abs(fine(grow_grain(marked, seen, everywhere, np.random.default_rng(0)))).max() < 0.2


def test_features_neither_give_nor_take_grain(skin):
    image, seen, everywhere = skin
    regions = everywhere.copy()
    regions[100:140, 150:220] = 0
    same = image.astype(np.float32)
    np.testing.assert_array_equal(grown(skin, regions=regions)[100:140, 150:220], same[100:140, 150:220])
    np.testing.assert_array_equal(grown(skin, regions=0 * regions), same)


def test_a_region_takes_its_own_grain_and_else_that_of_the_first(skin):
    image, seen, everywhere = skin
    regions = everywhere.copy()
    regions[SIDE // 2 :] = 2
    smooth = image.copy()
    smooth[SIDE // 2 :] = np.where(seen[SIDE // 2 :, :, None] == 1, SKIN, DARK)
    below = np.s_[SIDE // 2 + 24 : -16, SIDE // 2 + 16 : -16]
    own = grow_grain(smooth, seen, regions, np.random.default_rng(0))
    assert own[below].std(axis=(0, 1)).max() < 0.5
    hidden = np.where(regions == 2, 0.0, seen)
    taken = grow_grain(smooth, hidden, regions, np.random.default_rng(0))
    assert taken[below].std(axis=(0, 1)).min() > 1


def test_nothing_seen_nothing_grown(skin):
    image, seen, everywhere = skin
    np.testing.assert_array_equal(
        grow_grain(image, 0 * seen, everywhere, np.random.default_rng(0)), image.astype(np.float32)
    )
