import numpy as np

from caricli.geometry.weighted_medians import weighted_medians


def test_equal_weights_give_the_median():
    values = np.random.default_rng(0).normal(size=(101, 3))
    np.testing.assert_array_equal(weighted_medians(values, np.ones(101)), np.median(values, axis=0))


def test_whole_weights_are_as_many_values():
    generator = np.random.default_rng(1)
    values = generator.normal(size=(30, 2))
    weights = generator.integers(0, 5, 30)
    weights[0] += weights.sum() % 2 == 0
    repeated = np.repeat(values, weights, axis=0)
    np.testing.assert_array_equal(weighted_medians(values, weights), np.median(repeated, axis=0))


def test_where_nothing_else_counts_it_is_the_one_that_does():
    assert weighted_medians(np.array([[1.0], [5.0], [9.0]]), np.array([0.0, 0.3, 0.0])) == [5.0]


def test_of_two_that_count_the_same_it_is_the_smaller_one():
    np.testing.assert_array_equal(weighted_medians(np.array([[4.0, 1.0], [3.0, 2.0]]), np.ones(2)), [3, 1])
