"""A session done again."""

from collections.abc import Iterator, Sequence

from caricli.errors import naming
from caricli.methods.session.operations import operate
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures import Operation


def replay(start: Work, operations: Sequence[Operation], tools: Tools) -> Iterator[Work]:
    """The work after every operation in turn, the same bytes each time.

    start: Work before them. Raises InputError or NumericsError, which say the number of the operation, from 0.
    """
    work = start
    for number, operation in enumerate(operations):
        with naming(f"operation {number}"):
            work = operate(work, operation, tools)
        yield work
