import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from caricli.errors import InputError
from caricli.io.session import write_session
from caricli.methods.session.work import Work
from caricli.structures import Operation, Session, Start
from caricli.studio.desk import Desk
from caricli.studio.page import Page
from tests.studio.conftest import run_apart

BEGUN = Start("face.npz", "0" * 64)


@pytest.fixture
def desk(monkeypatch):
    """A desk with a face of a file, where all operations but one are done; the work is what is said of it."""

    def operate(work, operation, tools):
        if operation.name == "refused":
            raise InputError("no")
        return Work(work.face, remark=work.remark + operation.name)

    anything: Any = None
    monkeypatch.setattr("caricli.methods.session.history.operate", operate)
    monkeypatch.setattr("caricli.studio.desk.load_start", lambda path, tools: Work(anything, remark="empty "))
    own = Desk(anything, Work(anything, remark="face "), BEGUN)
    own.do(Operation("a"))
    return own


def test_a_session_from_an_empty_canvas_opens_whatever_is_there(desk):
    desk.open_session(Session(None, (Operation("b"), Operation("c"))))
    assert desk.start is None and desk.work.remark == "empty bc"
    desk.undo()
    assert desk.work.remark == "empty b"


@pytest.mark.parametrize("start", [None, BEGUN, Start("other.npz", "1" * 64)])
def test_a_session_that_is_refused_changes_nothing(desk, tmp_path, monkeypatch, start):
    path = tmp_path / "session.json"
    write_session(path, Session(start, (Operation("b"), Operation("refused"))))

    async def run(function, *values):
        return function(*values)

    studio: Any = SimpleNamespace(run=run)
    page = Page(studio, desk)
    said: list[str] = []
    monkeypatch.setattr(page, "say", lambda words, kind: said.append(words))
    with pytest.raises(InputError):
        run_apart(page.open(path))
    assert said == ["Opening session.json …"]
    assert desk.start == BEGUN and desk.work.remark == "face a"


def test_a_session_goes_on_from_its_start(desk):
    desk.open_session(Session(BEGUN, (Operation("b"),)))
    assert desk.start == BEGUN and desk.work.remark == "face b"


@pytest.mark.parametrize("name", ["b", "refused"])
def test_what_is_away_goes_on_when_its_file_is_opened(desk, monkeypatch, name):
    monkeypatch.setattr("caricli.studio.desk.start_of", lambda path: path)
    start: Any = Start("other.npz", "1" * 64)
    desk.away = Session(start, (Operation("b"), Operation(name)))
    desk.open(None)
    assert desk.work.remark == "empty "
    if name == "refused":
        with pytest.raises(InputError):
            desk.open(start)
        assert desk.start is None
    desk.open(start)
    assert desk.start == start and desk.work.remark == ("empty " if name == "refused" else "empty bb")
    desk.open(start)
    assert desk.work.remark == "empty "


def test_the_browser_keeps_what_is_left_where_undo_comes_before_an_answer(desk, monkeypatch):
    kept: list[Any] = []

    async def run(function, *values):
        result = function(*values)
        await asyncio.sleep(0)
        return result

    async def draw_and_undo():
        await asyncio.gather(page.do(Operation("b")), page.undo())

    studio: Any = SimpleNamespace(run=run)
    page = Page(studio, desk)
    keep = SimpleNamespace(run_method=lambda name, start, count, more, answered: kept.append((count, len(more))))
    monkeypatch.setattr(page, "keep", keep, raising=False)
    monkeypatch.setattr(page, "say", lambda *words: None)
    monkeypatch.setattr(page, "refresh", lambda answered: None)
    run_apart(draw_and_undo())
    assert kept == [(2, 1), (1, 0)] and desk.work.remark == "face a"
