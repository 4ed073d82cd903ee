import multiprocessing
import os
import time
from functools import partial

import pytest

from caricli.data.worker_pool import run_beside, worker_pool
from caricli.errors import CaricliError, InputError


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


def refuse(what):
    raise InputError(f"{what}: expected another, found this")


def test_what_runs_beside_says_what_it_returns_or_raises_and_ends_with_the_context():
    with run_beside(os.getpid) as answer:
        assert answer() != os.getpid()
    with run_beside(partial(refuse, "face.npz")) as answer, pytest.raises(InputError, match="face.npz: expected"):
        answer()
    with run_beside(partial(os._exit, 1)) as answer, pytest.raises(CaricliError, match="ended from outside"):
        answer()
    start = time.monotonic()
    with run_beside(partial(time.sleep, 600)):
        pass
    assert time.monotonic() - start < 300
    assert multiprocessing.active_children() == []
