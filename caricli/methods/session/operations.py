"""The operations of sessions by name."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from threadpoolctl import threadpool_limits

from caricli.errors import InputError, naming, shown
from caricli.methods.session.draw_operations import DRAW_OPERATIONS
from caricli.methods.session.face_operations import FACE_OPERATIONS
from caricli.methods.session.gesture_operations import GESTURE_OPERATIONS
from caricli.methods.session.mark_operations import MARK_OPERATIONS
from caricli.methods.session.parameters import Parameters
from caricli.methods.session.redraw_operations import REDRAW_OPERATIONS
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures import Operation

Operate = Callable[[Work, Parameters, Tools], Work]
"""What a name stands for: a pure function that checks its parameters. Raises InputError or NumericsError."""


def _begun_anew(operate: Operate) -> Operate:
    """The operation on a work of which nothing is said any more."""
    return lambda work, parameters, tools: operate(replace(work, remark=""), parameters, tools)


OPERATIONS: Mapping[str, Operate] = {
    name: _begun_anew(operate)
    for name, operate in {
        **DRAW_OPERATIONS,
        **REDRAW_OPERATIONS,
        **FACE_OPERATIONS,
        **MARK_OPERATIONS,
        **GESTURE_OPERATIONS,
    }.items()
}
"""One table of every mode."""


@threadpool_limits.wrap(limits=1)
def operate(work: Work, operation: Operation, tools: Tools) -> Work:
    """What an operation makes of a work, the same bytes on any number of cores, as sums are made by one thread.

    Raises InputError for an unknown one, and whatever it refuses.
    """
    if operation.name not in OPERATIONS:
        raise InputError(f"expected one of {', '.join(OPERATIONS)}, found {shown(operation.name, 60)!r}")
    with naming(operation.name):
        return OPERATIONS[operation.name](work, operation.parameters, tools)
