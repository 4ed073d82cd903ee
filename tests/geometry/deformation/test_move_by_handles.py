import numpy as np

from caricli.geometry.deformation.move_by_handles import move_by_handles

CORNERS = np.array([[0.0, 0], [4, 0], [4, 3], [0, 3], [2, 1]])


def test_an_affine_map_of_the_handles_is_one_of_the_plane():
    points = np.random.default_rng(0).uniform(-3, 7, (50, 2))
    matrix = np.array([[1.2, 0.3], [-0.4, 0.9]])
    moved = move_by_handles(points, CORNERS, CORNERS @ matrix + [5, -2])
    assert np.allclose(moved, points @ matrix + [5, -2], atol=1e-4)


def test_handles_go_where_they_are_taken_and_others_follow_smoothly():
    targets = CORNERS + np.array([[0, 0], [0, 0], [0, 0], [0, 0], [0.3, -0.2]])
    assert np.allclose(move_by_handles(CORNERS, CORNERS, targets), targets, atol=1e-3)
    line = np.column_stack([np.linspace(0.5, 3.5, 200), np.full(200, 1.0)])
    shift = move_by_handles(line, CORNERS, targets) - line
    assert np.abs(np.diff(shift, axis=0)).max() < 0.03


def test_handles_on_one_line_move_nothing_across_it():
    line = np.array([[0.0, 0], [1, 0], [2, 0]])
    moved = move_by_handles(np.array([[1.0, 2.0]]), line, line + [1, 0])
    assert np.isfinite(moved).all() and abs(moved[0, 0] - 2) < 0.1
