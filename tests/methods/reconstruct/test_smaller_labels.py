import numpy as np
import pytest

from caricli.methods.reconstruct.smaller_labels import smaller_labels
from caricli.structures import Camera

CORNERS = np.array([[-1.0, -1, 0], [1, 1, 0]])
ZOOMS = (0.1, 0.41, 0.5304929, 0.77, 0.9335)


@pytest.mark.parametrize("zoom", ZOOMS)
def test_every_pixel_has_the_label_at_its_middle(zoom):
    camera = Camera(50.0, np.diag([1.0, -1, -1]), np.array([61.0, 57.0]))
    columns = np.tile(np.arange(133, dtype=np.uint8), (121, 1))
    smaller, seen = smaller_labels(columns, camera, CORNERS, 100 * zoom)
    assert seen.scale == pytest.approx(50 * zoom) and smaller.shape == (round(121 * zoom), round(133 * zoom))
    # Where the column of a label is in the smaller map, by its camera.
    places = (smaller[0] - camera.translation[0]) / camera.scale * seen.scale + seen.translation[0]
    assert np.abs(places - np.arange(len(places))).max() <= 0.5 * zoom + 1e-9


@pytest.mark.parametrize("zoom", ZOOMS)
def test_the_mirror_image_has_the_mirror_image(zoom):
    regions = np.random.default_rng(0).integers(0, 9, (121, 133)).astype(np.uint8)
    camera = Camera(50.0, np.diag([1.0, -1, -1]), np.array([61.0, 57.0]))
    mirrored = Camera(50.0, camera.rotation, np.array([132 - 61.0, 57.0]))
    one, other = (
        smaller_labels(labels, view, CORNERS, 100 * zoom)
        for labels, view in ((regions, camera), (regions[:, ::-1], mirrored))
    )
    np.testing.assert_array_equal(one[0], other[0][:, ::-1])
    np.testing.assert_allclose(one[1].translation[0], one[0].shape[1] - 1 - other[1].translation[0])


def test_a_map_that_is_small_stays():
    regions = np.zeros((20, 30), np.uint8)
    camera = Camera(50.0, np.diag([1.0, -1, -1]), np.zeros(2))
    assert smaller_labels(regions, camera, CORNERS, 101.0) == (regions, camera)
