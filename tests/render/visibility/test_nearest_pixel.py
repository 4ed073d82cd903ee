import numpy as np
import pytest

from caricli.render.visibility.nearest_pixel import nearest_pixel


@pytest.mark.parametrize("count", [1, 7, 300])
def test_it_is_the_nearest_one(count):
    generator = np.random.default_rng(count)
    mask = np.zeros((70, 90), bool)
    mask.flat[generator.choice(mask.size, count, replace=False)] = True
    places = np.argwhere(mask)
    here = np.argwhere(np.ones_like(mask))
    least = np.linalg.norm(here[:, None] - places, axis=2).min(1)
    row, column = nearest_pixel(mask)
    assert mask[row, column].all()
    distance = np.hypot(row.ravel() - here[:, 0], column.ravel() - here[:, 1])
    assert (distance <= 1.05 * least + 1e-9).all()


def test_pixels_of_the_mask_are_their_own():
    mask = np.eye(9, dtype=bool)
    row, column = nearest_pixel(mask)
    np.testing.assert_array_equal(row[mask], np.arange(9))
    np.testing.assert_array_equal(column[mask], np.arange(9))


def test_an_empty_mask_is_refused():
    with pytest.raises(ValueError, match="empty"):
        nearest_pixel(np.zeros((3, 3), bool))
