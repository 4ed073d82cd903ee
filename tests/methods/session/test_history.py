from typing import Any

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.session import history, operations
from caricli.methods.session.history import CHECKPOINTS, NEWEST, History
from caricli.methods.session.replay import replay
from caricli.structures import Operation

NOTHING: Any = ()


@pytest.fixture
def counted(monkeypatch):
    """Works that are lists of numbers, and an operation that adds one; its calls are counted."""
    calls = []

    def add(work, parameters, tools):
        if parameters["n"] < 0:
            raise InputError("n: expected more than 0")
        calls.append(parameters["n"])
        return (*work, parameters["n"])

    monkeypatch.setattr(operations, "OPERATIONS", {"add": add})
    return calls


def adding(n):
    return Operation("add", {"n": n})


def test_undo_and_redo_lead_where_the_operations_lead(counted):
    kept = History(NOTHING, None)
    rng = np.random.default_rng(0)
    done: list[int] = []
    undone: list[int] = []
    for n in range(600):
        step = rng.choice(["do", "do", "undo", "redo"]) if n % 100 < 70 else "undo"
        if step == "do":
            kept.do(adding(n))
            done.append(n)
            undone.clear()
        elif step == "undo":
            kept.undo()
            undone += [done.pop()] if done else []
        else:
            kept.redo()
            done += [undone.pop()] if undone else []
        assert kept.work == tuple(done)
        assert [each.parameters["n"] for each in kept.done] == done
        assert len(kept.undone) == len(undone)
        assert kept.kept <= 3 + 2 * (NEWEST + CHECKPOINTS)


def test_memory_does_not_grow_and_going_back_far_costs_little(counted):
    kept = History(NOTHING, None)
    for n in range(2000):
        kept.do(adding(n))
    assert kept.kept <= 2 + NEWEST + CHECKPOINTS
    counted.clear()
    for _ in range(2000):
        kept.undo()
        assert kept.kept <= 3 + 2 * (NEWEST + CHECKPOINTS)
    assert kept.work == () and len(counted) < 2000 * (2000 / CHECKPOINTS / NEWEST + 1)
    assert kept.undo() == ()


def test_what_is_refused_changes_nothing(counted):
    kept = History(NOTHING, None)
    kept.do(adding(1))
    kept.do(adding(2))
    kept.undo()
    with pytest.raises(InputError, match="add: n: expected"):
        kept.do(adding(-1))
    with pytest.raises(InputError, match="expected one of add, found 'sub'"):
        kept.do(Operation("sub"))
    assert kept.work == (1,) and kept.redo() == (1, 2)


def test_replay_says_which_operation_fails(counted):
    with pytest.raises(InputError, match="operation 1: add: n: expected"):
        list(replay(NOTHING, [adding(1), adding(-1)], None))
    assert history.operate is operations.operate
