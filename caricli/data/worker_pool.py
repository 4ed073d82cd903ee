"""Fresh processes that share out work."""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from caricli import signals
from caricli.cores import usable_cores
from caricli.errors import CaricliError

T = TypeVar("T")

_ENDED = "a worker process was ended from outside; is there enough memory?"

_worker: Any = None
"""In a worker process: what all its jobs share."""


@contextlib.contextmanager
def worker_pool(workers: int | None, make: Callable[[], Any]) -> Iterator[Callable]:
    """Processes that end with the context whatever happens, and with this process, however it ends.

    workers: how many; None for one per usable core. make: called once a process, and what it returns is the first
    argument of all work there; as all that goes to a process, it must be of a module.
    Yields ``run(function, jobs)``, an iterator over ``function(made, job)`` in the order of the jobs.
    Raises CaricliError when a process was ended from outside.
    """
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers or usable_cores(), context, initializer=_start, initargs=(make,))
    try:
        yield partial(_run, pool)
    except BrokenProcessPool as error:
        raise CaricliError(_ENDED) from error
    finally:
        with signals.held():
            pool.shutdown(cancel_futures=True)


def _run(pool: ProcessPoolExecutor, function: Callable, jobs: Iterable) -> Iterator:
    with _starting():
        return pool.map(partial(_work, function), jobs)


@contextlib.contextmanager
def _starting() -> Iterator[None]:
    """Processes start here and inherit the mask, so that Ctrl-C, which reaches them too, is left to the parent."""
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with signals.held():  # what is stopped while it starts a process does not know of it
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


# ---------------------------------------------------------------- in a worker


def _start(make: Callable[[], Any]) -> None:
    global _worker
    _belong_to_parent()
    threadpool_limits(1)
    # OpenCV has threads of its own, and reads this when it is imported, which no work has done yet.
    os.environ["OPENCV_FOR_THREADS_NUM"] = "1"
    _worker = make()


def _belong_to_parent() -> None:
    # Ctrl-C reaches the whole process group; the parent ends the workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A parent that was killed tells nobody, and a worker would wait for its next job for ever."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _work(function: Callable, job: Any) -> Any:
    return function(_worker, job)
