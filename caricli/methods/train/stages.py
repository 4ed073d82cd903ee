"""How work in several stages says how far it is."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

Report = Callable[[int, int], object]
"""Called with what is done and the total."""

Stages = Callable[[str], AbstractContextManager[Report]]
"""Called with the name of a stage, gives the context in which it is done, and its Report."""


@contextmanager
def silent(stage: str) -> Iterator[Report]:
    """The Stages of work that nobody watches."""
    yield unwatched


def unwatched(done: int, total: int) -> None:
    """The Report of work that nobody watches."""
