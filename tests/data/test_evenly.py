import numpy as np
import pytest

from caricli.data.evenly import evenly


@pytest.mark.parametrize("many", [200, 201, 399, 400, 1000])
def test_they_are_from_all_over_them(many):
    chosen = np.array(evenly(range(many), 200))
    assert len(chosen) == 200 and chosen[0] == 0 and chosen[-1] == many - 1
    steps = np.diff(chosen)
    assert steps.min() >= 1 and steps.max() - steps.min() <= 1


def test_of_few_all_are_taken():
    assert evenly("abc", 5) == ["a", "b", "c"] and evenly((), 5) == [] and evenly([7, 8, 9], 1) == [7]
