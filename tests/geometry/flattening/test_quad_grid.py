import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.flattening.quad_grid import quad_grid


def patch(rows, columns):
    ids = np.arange(rows * columns).reshape(rows, columns)
    return np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], -1).reshape(-1, 4)


@pytest.mark.parametrize("size", [(2, 2), (2, 5), (4, 4), (3, 7), (7, 3)])
def test_rows_and_columns_come_back_whatever_the_order(size):
    generator = np.random.default_rng(1)
    names = generator.permutation(size[0] * size[1])
    quads = names[patch(*size)]
    quads = np.array([np.roll(quad, generator.integers(4)) for quad in quads])[generator.permutation(len(quads))]
    grid = quad_grid(quads)
    assert grid.shape == (min(size), max(size))
    again = {frozenset(grid.ravel()[quad].tolist()) for quad in patch(*grid.shape)}
    assert again == {frozenset(quad.tolist()) for quad in quads}
    turned = {tuple(np.roll(quad, -int(quad.argmin())).tolist()) for quad in grid.ravel()[patch(*grid.shape)]}
    assert turned == {tuple(np.roll(quad, -int(quad.argmin())).tolist()) for quad in quads}
    assert min(grid[[0, 0, -1, -1], [0, -1, 0, -1]]) in grid[0, [0, -1]]


@pytest.mark.parametrize(
    "quads",
    [
        np.delete(patch(4, 4), 4, axis=0),  # a hole
        np.delete(patch(4, 4), 0, axis=0),  # a corner is missing
        np.concatenate([patch(2, 2), patch(2, 2) + 4]),  # two patches
    ],
)
def test_another_patch_is_refused(quads):
    with pytest.raises(InputError, match="grid of quads"):
        quad_grid(quads)
