import itertools

import pytest

from caricli.render.in_parallel import in_parallel


def test_results_come_in_order_and_few_things_wait():
    asked = []

    def things():
        for k in itertools.count():
            asked.append(k)
            yield k

    results = in_parallel(lambda k: 2 * k, things())
    assert [next(results) for _ in range(50)] == [2 * k for k in range(50)]
    assert len(asked) < 50 + 300


def test_an_error_comes_out():
    with pytest.raises(ZeroDivisionError):
        list(in_parallel(lambda k: 1 // k, [1, 0]))
