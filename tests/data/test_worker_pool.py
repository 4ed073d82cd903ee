import multiprocessing
import os
import time
from functools import partial

import pytest

from caricli.data.worker_pool import worker_pool
from caricli.errors import CaricliError


class Counter:
    """What a worker makes once."""

    def __init__(self, start):
        self.start = start
        self.calls = 0

    def count(self, job):
        self.calls += 1
        return self.start + job, self.calls, os.getpid()

    def end(self, job):
        os._exit(1)


def test_jobs_come_back_in_order_from_what_a_process_made_once():
    with worker_pool(1, partial(Counter, 100)) as run:
        results = list(run(Counter.count, range(5)))
    assert [value for value, _, _ in results] == [100, 101, 102, 103, 104]
    assert [calls for _, calls, _ in results] == [1, 2, 3, 4, 5]
    assert {process for _, _, process in results}.isdisjoint({os.getpid()})


def test_a_process_that_ends_is_an_error_in_one_line():
    with pytest.raises(CaricliError, match="ended from outside"), worker_pool(1, partial(Counter, 0)) as run:
        list(run(Counter.end, range(2)))


def test_no_process_outlives_the_context():
    with pytest.raises(KeyError), worker_pool(2, partial(Counter, 0)) as run:
        next(run(Counter.count, range(50)))
        raise KeyError
    end = time.monotonic() + 20
    while multiprocessing.active_children() and time.monotonic() < end:
        time.sleep(0.05)
    assert multiprocessing.active_children() == []
