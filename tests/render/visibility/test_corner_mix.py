import numpy as np
import pytest

from caricli.render.visibility.corner_mix import corner_mix
from caricli.render.visibility.rasterise import rasterise


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_it_mixes_what_the_corners_have(ball, kind):
    vertices, faces = ball
    raster = rasterise(20 * vertices + [25, 25, 0], faces, 50, 50)
    covered = raster.face >= 0
    corners = faces[raster.face[covered]]
    weights = raster.barycentric[covered].astype(kind)
    mix = corner_mix(corners, weights, len(vertices))
    assert mix.shape == (covered.sum(), len(vertices)) and mix.dtype == kind and mix.indices.dtype == np.int32
    values = np.random.default_rng(0).normal(size=(len(vertices), 4)).astype(kind)
    np.testing.assert_allclose(mix @ values, np.einsum("nk,nkc->nc", weights, values[corners]), rtol=1e-5, atol=1e-6)


def test_of_no_places_it_is_empty():
    assert corner_mix(np.zeros((0, 3), int), np.zeros((0, 3), np.float32), 7).shape == (0, 7)


def test_a_corner_that_comes_twice_counts_twice():
    mix = corner_mix(np.array([[1, 1, 2]]), np.array([[0.25, 0.25, 0.5]]), 3)
    np.testing.assert_array_equal(mix @ [5.0, 8, 4], [6])
