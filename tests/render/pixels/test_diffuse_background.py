import numpy as np
import pytest

from caricli.render.pixels import diffuse_background as module
from caricli.render.pixels.diffuse_background import LAYERS, diffuse_background


def by_hand(image, mask):
    """The breadth-first search, pixel by pixel: a layer sees what was known before it."""
    known = {(r, c): image[r, c].astype(float) for r, c in np.argwhere(mask).tolist()}
    while True:
        fresh = {}
        for r in range(mask.shape[0]):
            for c in range(mask.shape[1]):
                beside = [known.get((r + i, c + j)) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
                beside = [colour for colour in beside if colour is not None]
                if (r, c) not in known and beside:
                    fresh[r, c] = np.mean(beside, axis=0)
        if not fresh:
            break
        known |= fresh
    return np.array([[known[r, c] for c in range(mask.shape[1])] for r in range(mask.shape[0])])


@pytest.mark.parametrize("seed", range(4))
def test_layers_are_those_of_a_search(seed):
    generator = np.random.default_rng(seed)
    image, mask = generator.integers(0, 256, (17, 23, 3), np.uint8), generator.random((17, 23)) < 0.03
    mask[5:9, 4:9] = True
    before = image.copy()
    found = diffuse_background(image, mask)
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(image, before)
    np.testing.assert_array_equal(found[mask], image[mask])
    np.testing.assert_allclose(found, by_hand(image, mask), atol=0.51)


def test_nothing_of_the_background_is_left():
    image = np.zeros((60, 60, 3), np.uint8)
    image[:], image[20:40, 20:40] = (255, 0, 255), (90, 140, 60)
    mask = np.zeros((60, 60), bool)
    mask[20:40, 20:40] = True
    assert (diffuse_background(image, mask) == (90, 140, 60)).all()


def test_far_pixels_take_the_nearest_colour(monkeypatch):
    image = np.zeros((3, 400, 3), np.uint8)
    image[:, :4], image[:, -4:] = 200, 40
    mask = image[..., 0] > 0
    found = diffuse_background(image, mask)[1, :, 0]
    assert found[LAYERS + 20] == 200 and found[-LAYERS - 20] == 40
    assert set(found[:190]) == {200} and set(found[-190:]) == {40}
    monkeypatch.setattr(module, "LAYERS", 2)
    np.testing.assert_array_equal(diffuse_background(image, mask)[1, :, 0], found)


def test_an_empty_and_a_full_mask_change_nothing():
    image = np.random.default_rng(0).integers(0, 256, (6, 7, 3), np.uint8)
    for mask in (np.zeros((6, 7), bool), np.ones((6, 7), bool)):
        found = diffuse_background(image, mask)
        np.testing.assert_array_equal(found, image)
        assert not np.shares_memory(found, image)
