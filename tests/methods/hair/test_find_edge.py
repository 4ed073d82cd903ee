from itertools import product

import numpy as np

from caricli.methods.hair.find_edge import find_edge


def test_it_is_the_best_of_all_edges():
    generator = np.random.default_rng(0)
    steady = 0.7
    for _ in range(5):
        votes = generator.normal(size=(3, 5))
        votes[:, 2] = (3, 3, -3)  # the column that is sure begins

        def score(edge, votes=votes):
            gain = sum(votes[:row, column].sum() for column, row in enumerate(edge))
            return gain - steady * np.abs(np.diff([*edge, edge[0]])).sum()

        best = max(product(range(4), repeat=5), key=score)
        edge = find_edge(votes, steady)
        if best[2] == 2:
            np.testing.assert_allclose(score(edge), score(best))


def test_holes_do_not_end_it():
    votes = np.where(np.arange(20)[:, None] < 12, 1.0, -1.0) * np.ones(16)
    votes[3:6, 4:7] = -1
    np.testing.assert_array_equal(find_edge(votes, 0.5), 12)
