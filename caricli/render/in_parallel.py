"""One function over many things on all processors."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

from caricli.cores import usable_cores

T = TypeVar("T")
R = TypeVar("R")


def in_parallel(function: Callable[[T], R], things: Iterable[T]) -> Iterator[R]:
    """Results of a function in the order of what they are of, a few of which are worked on at a time.

    Threads pay where most of the work is a kernel's: those run beside each other. At most one thing more than there
    are processors is waiting, whatever the number of things.
    """
    workers = usable_cores()
    with ThreadPoolExecutor(workers) as pool:
        waiting: deque[Future[R]] = deque()
        for thing in things:
            waiting.append(pool.submit(function, thing))
            if len(waiting) > workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def do_in_parallel(*jobs: Callable[[], Any]) -> list[Any]:
    """What jobs return, none of which waits for another, in their order."""
    with ThreadPoolExecutor(usable_cores()) as pool:
        return [each.result() for each in [pool.submit(job) for job in jobs]]
