from typing import Any

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.landmarks import write_landmarks
from caricli.methods.session.work import Work
from caricli.structures import Landmarks
from caricli.studio.server import MOST_DESKS, Studio


@pytest.fixture
def studio(monkeypatch):
    """A studio without a model."""
    anything: Any = None
    monkeypatch.setattr("caricli.studio.server.load_start", lambda path, tools: Work(anything))
    monkeypatch.setattr("caricli.studio.server.dressed_vertices", lambda face, tools: None)
    return Studio(anything, None)


def test_a_folder_begins_with_the_first_picture_that_can_be_read(monkeypatch, tmp_path):
    for name in ("a.png", "b.png", "c.png"):
        (tmp_path / name).write_text("a picture")
    write_landmarks(tmp_path / "b.json", Landmarks(np.random.default_rng(0).uniform(0, 40, (68, 2))))
    anything: Any = None
    damaged = {"a.png"}

    def load_start(path, tools):
        if path.name in damaged:
            raise InputError(path.name)
        return Work(anything)

    monkeypatch.setattr("caricli.studio.server.load_start", load_start)
    monkeypatch.setattr("caricli.studio.server.dressed_vertices", lambda face, tools: None)
    assert Studio(anything, tmp_path).picture == tmp_path / "c.png"
    damaged.add("c.png")
    assert Studio(anything, tmp_path).picture == tmp_path / "b.png"
    damaged.add("b.png")
    with pytest.raises(InputError, match=r"a\.png"):
        Studio(anything, tmp_path)


def test_tabs_that_no_browser_shows_end_first(studio):
    shown = {0, 2, *range(3, 100)}
    desks = []
    for number in range(MOST_DESKS + 2):
        desks.append(studio.new_desk(lambda number=number: number in shown))
        studio.opened[desks[-1].key] = print
    left = [number for number, desk in enumerate(desks) if desk.key in studio.desks]
    assert left == [2, *range(3, MOST_DESKS + 2)]
    assert studio.desks.keys() == studio.here.keys() == studio.opened.keys()
