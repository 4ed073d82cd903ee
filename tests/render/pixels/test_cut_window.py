import numpy as np
import pytest

from caricli.render.pixels.cut_window import cut_window
from caricli.structures.detection import turn_axes


def ramp(height=90, width=120):
    """A picture whose first two channels are its pixels' places."""
    y, x = np.indices((height, width))
    return np.stack([x, y, 0 * x], -1).astype(np.uint8)


@pytest.mark.parametrize("scale", [2.0, 1.0, 0.6, 0.3, 0.11])
@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_pixels_come_from_where_the_map_says(scale, angle):
    linear = scale * turn_axes(angle)
    size = (round(60 * scale), round(40 * scale))
    matrix = np.column_stack([linear, (np.array(size) - 1) / 2 - linear @ [60, 45]])
    window = cut_window(ramp(), matrix, size)
    assert window.shape == (size[1], size[0], 3) and window.dtype == np.uint8
    y, x = np.indices(window.shape[:2])
    there = np.linalg.solve(linear, np.stack([x, y], -1).reshape(-1, 2).T - matrix[:, 2:]).T
    inner = (np.abs(there - [60, 45]) < [45, 30]).all(1)
    errors = window[..., :2].reshape(-1, 2)[inner] - there[inner]
    # Whole numbers are rounded twice.
    assert np.abs(errors).max() < 1 and np.abs(errors.mean(0)).max() < 0.25


def test_the_mean_of_what_is_made_smaller_stays():
    picture = np.random.default_rng(0).integers(0, 256, (256, 256, 3), np.uint8)
    window = cut_window(picture, np.array([[0.125, 0, -0.4375], [0, 0.125, -0.4375]]), (32, 32))
    assert abs(window.mean() - picture.mean()) < 1
    assert window.std() < 0.2 * picture.std()


@pytest.mark.parametrize("shape", [(1, 1), (20, 20000), (3, 5000)])
def test_any_shape_goes_on_beyond_its_edges(shape):
    picture = np.full((*shape, 3), 77, np.uint8)
    scale = 96 / max(shape)
    window = cut_window(picture, np.array([[scale, 0, 5], [0, scale, 6]]), (128, 64))
    assert window.shape == (64, 128, 3) and (window == 77).all()
