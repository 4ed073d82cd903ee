import numpy as np
import pytest

from caricli.methods.evaluate.ratio_interval import ratio_interval


def test_a_ratio_is_of_sums_and_lies_between_those_of_its_people():
    """Two people, one of whom has a tenth and the other a half of a larger base."""
    above = np.array([1.0, 0.0, 15.0, 10.0])
    below = np.array([6.0, 4.0, 25.0, 25.0])
    assert ratio_interval(above, below, np.array([3, 3, 8, 8])) == pytest.approx((26 / 60, 0.1, 0.5))


def test_draws_are_those_of_a_seed():
    above, below = np.random.default_rng(1).random((2, 40))
    people = np.arange(40)
    first = ratio_interval(above, below, people, draws=50)
    assert first == ratio_interval(above, below, people, draws=50)
    assert first[1:] != ratio_interval(above, below, people, draws=50, seed=1)[1:]


def test_nothing_of_nothing_is_nothing():
    assert ratio_interval(np.zeros(3), np.zeros(3), np.arange(3)) == (0, 0, 0)
