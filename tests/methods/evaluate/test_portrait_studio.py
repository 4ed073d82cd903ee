import numpy as np
import pytest

from caricli.render.visibility.rasterise import rasterise
from tests.methods.evaluate.conftest import SIZE


def test_a_portrait_shows_the_face_where_its_camera_and_mask_say(portrait, head_template):
    placed = portrait.camera.place(portrait.truth)
    silhouette = rasterise(placed, head_template.faces, SIZE, SIZE).face >= 0
    # Lids leave out the eyeballs, and borders are coverage here and centres of pixels there.
    assert (silhouette != portrait.mask).mean() < 0.02
    assert 0.05 < portrait.mask.mean() < 0.8
    assert np.linalg.det(portrait.camera.rotation) == pytest.approx(1)
    note = head_template.annotation
    wanted = portrait.camera.project(portrait.truth[note.landmarks[17:68]])
    assert portrait.points.shape == (68, 2) and np.allclose(portrait.points[17:], wanted)
    assert ((portrait.points > 0) & (portrait.points < SIZE)).all()


def test_the_seed_makes_picture_and_noise(studio, strangers, portrait):
    again = studio.portray("someone", strangers[1], np.random.default_rng(4))
    assert np.array_equal(again.image, portrait.image) and np.array_equal(again.points, portrait.points)
    noisy = studio.portray("someone", strangers[1], np.random.default_rng(4), noise=2.0)
    offset = (noisy.points - portrait.points) / np.linalg.norm(np.ptp(portrait.points, axis=0))
    assert np.std(offset) == pytest.approx(0.02, rel=0.2)
    other = studio.portray("someone", strangers[1], np.random.default_rng(5))
    assert not np.array_equal(other.image, portrait.image)


def test_background_is_not_of_the_head(studio, strangers):
    """Half of the backgrounds are plain, and the rest are not."""
    spreads = []
    for seed in range(4):
        portrait = studio.portray("someone", strangers[0], np.random.default_rng(seed))
        # Pixels on the outline are mixtures.
        rows, columns = np.nonzero(~portrait.mask)
        far = (columns < 4) | (columns >= SIZE - 4)
        spreads.append(portrait.image[rows[far], columns[far]].astype(float).std(0).max())
    assert min(spreads) < 1e-9 and max(spreads) > 5
