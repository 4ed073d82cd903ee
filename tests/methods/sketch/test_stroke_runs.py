import numpy as np
import pytest

from caricli.methods.sketch.stroke_runs import stroke_runs


def logs_of(classes, surely=0.9):
    """(N, 3) of places that are likely of some classes."""
    chances = np.full((len(classes), 3), (1 - surely) / 2)
    chances[np.arange(len(classes)), classes] = surely
    return np.log(chances)


def test_runs_cover_all_places_and_change_where_the_class_does():
    assert stroke_runs(logs_of([0] * 20 + [2] * 30 + [1] * 10), 5.0) == [(0, 20), (20, 50), (50, 60)]
    assert stroke_runs(logs_of([1]), 5.0) == [(0, 1)]


def test_a_change_that_costs_more_than_it_gains_is_none():
    mixed = logs_of([0] * 20 + [2] * 2 + [0] * 20)
    gained = 2 * (np.log(0.9) - np.log(0.05))
    assert stroke_runs(mixed, gained / 2 + 0.1) == [(0, 42)]
    assert stroke_runs(mixed, gained / 2 - 0.1) == [(0, 20), (20, 22), (22, 42)]


@pytest.mark.parametrize("seed", range(5))
def test_they_are_the_likeliest_of_all(seed):
    """Beside all paths through six places."""
    generator = np.random.default_rng(seed)
    logs = np.log(generator.dirichlet(np.ones(3), 6))
    paths = np.stack(np.meshgrid(*[range(3)] * 6, indexing="ij"), -1).reshape(-1, 6)
    scores = logs[np.arange(6), paths].sum(1) - 0.7 * (np.diff(paths, axis=1) != 0).sum(1)
    best = paths[scores.argmax()]
    starts = [0, *(np.flatnonzero(np.diff(best)) + 1).tolist()]
    assert [start for start, _ in stroke_runs(logs, 0.7)] == starts
