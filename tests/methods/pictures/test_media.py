import numpy as np
import pytest

from caricli.methods.pictures.media import MEDIA


@pytest.fixture
def scene():
    """A disc with a light and a dark half before a grey ground, and its regions."""
    rows, columns = np.mgrid[:96, :96] - 47.5
    disc = rows**2 + columns**2 < 30**2
    image = np.full((96, 96, 3), 0.6, np.float32)
    image[disc] = [0.9, 0.7, 0.5]
    image[disc & (columns > 0)] = [0.3, 0.2, 0.1]
    return image, disc.astype(np.uint8)


@pytest.mark.parametrize("medium", MEDIA)
def test_every_medium_shows_the_scene_and_leaves_it_as_it_is(scene, medium):
    image, region = scene
    before = image.copy()
    draw, share = MEDIA[medium]
    assert share > 0
    for seed in range(6):
        drawn = np.clip(draw(image, region, np.random.default_rng(seed)), 0, 1)
        assert drawn.shape == image.shape and np.isfinite(drawn).all()
        # Whatever it is made with, the shape can be told.
        grey = drawn.mean(2)
        assert grey.std() > 0.02
        np.testing.assert_array_equal(
            draw(image, region, np.random.default_rng(seed)), draw(image, region, np.random.default_rng(seed))
        )
    np.testing.assert_array_equal(image, before)


def test_media_share_out_all_pictures():
    assert sum(share for _, share in MEDIA.values()) == pytest.approx(1)
