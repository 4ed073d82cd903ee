import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.visibility import covered_pixels as module
from caricli.render.visibility.covered_pixels import covered_pixels
from caricli.render.visibility.rasterise import rasterise


def _soup(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of all sizes, also beyond the picture."""
    generator = np.random.default_rng(seed)
    corners = generator.normal(size=(60, 3, 3)) * generator.uniform(1, 40, (60, 1, 1)) + [30, 20, 50]
    return corners.reshape(-1, 3), np.arange(180).reshape(-1, 3)


@pytest.mark.parametrize("size", [(64, 40), (1, 40), (64, 1)])
def test_it_covers_what_rays_meet(size):
    for seed in range(5):
        vertices, faces = _soup(seed)
        expected = rasterise(vertices, faces, *size).face >= 0
        assert expected.any() or 1 in size
        np.testing.assert_array_equal(covered_pixels(vertices, faces, *size), expected)


def test_blocks_change_nothing(monkeypatch):
    vertices, faces = _soup(9)
    whole = covered_pixels(vertices, faces, 64, 40)
    monkeypatch.setattr(module, "_BLOCK", 50)
    np.testing.assert_array_equal(covered_pixels(vertices, faces, 64, 40), whole)


def test_borders_belong_to_a_triangle():
    square = np.array([[1.0, 1, 0], [3, 1, 0], [3, 2, 0], [1, 2, 0]])
    covered = covered_pixels(square, np.array([[0, 1, 2], [0, 2, 3]]), 5, 4)
    assert covered[1:3, 1:4].all() and covered.sum() == 6


def test_no_triangle_covers_nothing():
    assert not covered_pixels(np.zeros((1, 3)), np.zeros((0, 3), int), 5, 4).any()


def test_what_is_not_finite_is_refused():
    with pytest.raises(InputError, match="finite"):
        covered_pixels(np.full((3, 3), np.nan), np.array([[0, 1, 2]]), 5, 4)
