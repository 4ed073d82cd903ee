"""How work says how far it is: in stages, and epoch by epoch."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass

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


@dataclass(frozen=True)
class EpochRecord:
    """What an epoch came to: mean loss; errors on what is trained on and on what is not, None where this was not asked.

    Of what they are, each training says. best: whether the latter is the least so far.
    """

    epoch: int
    loss: float
    train_error: float
    validation_error: float | None
    best: bool
