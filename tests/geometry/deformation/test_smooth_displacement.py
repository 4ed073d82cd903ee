import numpy as np
import pytest

from caricli.geometry.deformation.smooth_displacement import (
    Borders,
    Samples,
    Smoothness,
    least_areas,
    smooth_displacement,
)

WITHIN = Borders(True, True, True, True)
ALONE = Borders(False, False, False, False)
SHAPE = (24, 30)


def samples(places, moves, weight=1.0):
    return Samples(np.array(places, float), np.array(moves, float), np.full(len(places), weight))


def patch(move):
    """Samples of a square in the middle that all move the same way."""
    x, y = np.meshgrid(np.arange(11, 18, 0.5), np.arange(9, 15, 0.5))
    places = np.stack([x.ravel(), y.ravel()], 1)
    return samples(places, np.tile(move, (len(places), 1)), 0.25)


def test_what_samples_say_is_met_and_the_picture_around_stays():
    moves = smooth_displacement(patch([1.0, -0.5]), SHAPE, WITHIN, Smoothness())
    np.testing.assert_allclose(moves[12, 14], [1.0, -0.5], atol=0.05)
    assert (moves[[0, 1, -2, -1]] == 0).all() and (moves[:, [0, 1, -2, -1]] == 0).all()
    assert 0 < np.linalg.norm(moves[4, 14]) < 1, "between them it fades"


def test_on_the_border_of_a_picture_nodes_slide_but_do_not_leave_it():
    edge = samples([[0, y] for y in range(8, 16)], [[0.0, 1.0]] * 8, 5.0)
    moves = smooth_displacement(edge, SHAPE, ALONE, Smoothness())
    assert (moves[:, [0, -1], 0] == 0).all() and (moves[[0, -1], :, 1] == 0).all()
    assert moves[12, 0, 1] > 0.8


@pytest.mark.parametrize("side", ["left", "top", "right", "bottom"])
def test_only_where_the_picture_goes_on_a_border_stays(side):
    borders = Borders(*(name == side for name in ("left", "top", "right", "bottom")))
    moves = smooth_displacement(patch([1.0, -0.5]), SHAPE, borders, Smoothness(4.0))
    for name, own in (
        ("left", moves[:, :2]),
        ("right", moves[:, :-3:-1]),
        ("top", moves[:2]),
        ("bottom", moves[:-3:-1]),
    ):
        assert (own == 0).all() == (name == side)


def test_linear_displacements_are_kept_between_samples():
    """A plate that bends nowhere costs nothing: far from borders an affine displacement is met exactly."""
    x, y = np.meshgrid(np.arange(5, 25), np.arange(5, 19))
    places = np.stack([x.ravel(), y.ravel()], 1).astype(float)
    affine = (places - [15, 12]) @ [[0.05, 0.02], [-0.03, 0.04]]
    some = np.random.default_rng(0).random(len(places)) < 0.3
    moves = smooth_displacement(samples(places[some], affine[some], 50.0), SHAPE, ALONE, Smoothness(0.5))
    np.testing.assert_allclose(moves[10:14, 12:18], affine.reshape(14, 20, 2)[5:9, 7:13], atol=5e-3)


@pytest.mark.parametrize("move", [[8.0, 0.0], [-6.0, 7.0], [30.0, 0.0]])
def test_nothing_folds(move):
    """Samples that pull further than the way to the border would fold the grid."""
    moves = smooth_displacement(patch(move), SHAPE, WITHIN, Smoothness())
    assert least_areas(moves).min() >= Smoothness().least
    assert np.linalg.norm(moves[12, 14]) > 1, "but it still goes there"


def test_what_no_loosening_unfolds_is_made_weaker_and_no_weaker_than_it_has_to_be():
    """Samples that weigh so much that a quarter of a quarter of it still folds the grid."""
    swapped = samples([[12, 12], [16, 12]], [[4, 0], [-4, 0]], 1e7)
    moves = smooth_displacement(swapped, SHAPE, WITHIN, Smoothness(0.5))
    assert 0.2 <= least_areas(moves).min() < 0.201


def test_samples_that_contradict_each_other_do_not_fold_it_either():
    swapped = samples([[12, 12], [16, 12]], [[4, 0], [-4, 0]], 20.0)
    moves = smooth_displacement(swapped, SHAPE, WITHIN, Smoothness(0.5))
    assert least_areas(moves).min() >= Smoothness().least


def test_folds_are_seen():
    moves = np.zeros((4, 4, 2))
    assert (least_areas(moves) == 1).all()
    moves[1, 1] = [1.5, 0]
    assert least_areas(moves)[1, 1] < 0 < least_areas(moves)[2, 2]


def test_it_is_the_least_of_a_dense_system():
    """Rows of samples, and of second differences times the square of the length, node by node."""
    rows, columns = shape = (6, 7)
    generator = np.random.default_rng(4)
    places = generator.uniform(0, [columns - 1, rows - 1], (9, 2))
    given = Samples(places, 0.1 * generator.normal(size=(9, 2)), generator.uniform(0.5, 2, 9))
    length = 1.3
    node = np.arange(rows * columns).reshape(shape)
    equations = []
    for (x, y), weight in zip(places, given.weights, strict=True):
        row, left, top = np.zeros(rows * columns), int(x), int(y)
        for i, down in ((top, top + 1 - y), (top + 1, y - top)):
            for j, across in ((left, left + 1 - x), (left + 1, x - left)):
                row[node[i, j]] = weight**0.5 * down * across
        equations.append(row)
    for parts, factor in (([(0, 0, 1), (0, 1, -2), (0, 2, 1)], 1), ([(0, 0, 1), (1, 0, -2), (2, 0, 1)], 1),
                          ([(0, 0, 1), (0, 1, -1), (1, 0, -1), (1, 1, 1)], 2**0.5)):  # fmt: skip
        height, width = (max(part[k] for part in parts) for k in (0, 1))
        for i in range(rows - height):
            for j in range(columns - width):
                row = np.zeros(rows * columns)
                for down, across, value in parts:
                    row[node[i + down, j + across]] = length**2 * factor * value
                equations.append(row)
    system = np.array(equations)
    expected = np.zeros((rows * columns, 2))
    for axis, free in enumerate((node[:, 1:-1].ravel(), node[1:-1].ravel())):
        right = np.zeros(len(system))
        right[:9] = given.weights**0.5 * given.moves[:, axis]
        expected[free, axis] = np.linalg.lstsq(system[:, free], right, rcond=None)[0]
    found = smooth_displacement(given, shape, ALONE, Smoothness(length))
    np.testing.assert_allclose(found.reshape(-1, 2), expected, atol=1e-6)
