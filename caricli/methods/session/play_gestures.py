"""A script of operations, arrows among them, played from a face."""

from collections.abc import Sequence

from caricli.errors import naming
from caricli.methods.session.gesture_operations import REDO, UNDO, meaning_of
from caricli.methods.session.history import History
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures import Operation


def play_gestures(start: Work, operations: Sequence[Operation], tools: Tools) -> History:
    """Do operations in turn; strokes are what the network takes them for, and arrows undo and redo.

    start: Work before them. Returns the History, whose ``done`` are what the strokes meant. Raises InputError or
    NumericsError, which say the number of the operation, from 0.
    """
    history = History(start, tools)
    for number, operation in enumerate(operations):
        with naming(f"operation {number}"):
            meant = meaning_of(operation, tools) if operation.name == "gesture" else operation
            if meant == UNDO:
                history.undo()
            elif meant == REDO:
                history.redo()
            else:
                assert isinstance(meant, Operation)
                history.do(meant)
    return history
