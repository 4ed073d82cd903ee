"""Undo and redo in bounded memory."""

from caricli.methods.session.operations import operate
from caricli.methods.session.replay import replay
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures import Operation

NEWEST = 12
"""Works that are kept around the present one: undo and redo among them take no time."""

CHECKPOINTS = 12
"""Older works that are kept, evenly spaced: between them operations are done again."""


class History:
    """Operations that were done, and those that were undone and can be redone.

    ``work``: the present Work. ``done``: Operations that lead to it. ``undone``: those that redo brings back, the next
    one last.
    """

    def __init__(self, start: Work, tools: Tools) -> None:
        """start: Work before the first operation."""
        self.tools = tools
        self.done: list[Operation] = []
        self.undone: list[Operation] = []
        self._works = {0: start}
        self._spacing = NEWEST

    @property
    def start(self) -> Work:
        """Before the first operation."""
        return self._works[0]

    @property
    def work(self) -> Work:
        """The present."""
        return self._works[len(self.done)]

    @property
    def kept(self) -> int:
        """How many works are in memory, at most 1 + NEWEST + CHECKPOINTS and what was just redone."""
        return len(self._works)

    def do(self, operation: Operation) -> Work:
        """Do an operation; what was undone is gone. Where it is refused, nothing changes. Raises as ``operate``."""
        work = operate(self.work, operation, self.tools)
        self.undone.clear()
        self._works = {number: each for number, each in self._works.items() if number <= len(self.done)}
        self.done.append(operation)
        self._keep(work)
        return work

    def undo(self) -> Work:
        """Go one operation back, where there is one."""
        if self.done:
            self.undone.append(self.done.pop())
            self._reach()
        return self.work

    def redo(self) -> Work:
        """Do again what was undone last, where there is something."""
        if self.undone:
            self.done.append(self.undone.pop())
            self._reach()
        return self.work

    def _reach(self) -> None:
        """Have the present work, from the nearest one before it."""
        present = len(self.done)
        if present in self._works:
            return
        before = max(number for number in self._works if number < present)
        for number, work in enumerate(replay(self._works[before], self.done[before:], self.tools), before + 1):
            # Who undoes once will undo again.
            if number > present - NEWEST:
                self._works[number] = work
        self._forget()

    def _keep(self, work: Work) -> None:
        self._works[len(self.done)] = work
        while len(self.done) // self._spacing > CHECKPOINTS:
            self._spacing *= 2
        self._forget()

    def _forget(self) -> None:
        """Keep the start, the works near the present, and evenly spaced ones."""
        present = len(self.done)
        self._works = {
            number: work
            for number, work in self._works.items()
            if number % self._spacing == 0
            or abs(number - present) <= NEWEST // 2
            or present - NEWEST < number <= present
        }
