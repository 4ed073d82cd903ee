import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from caricli.methods.edit.handle_points import handle_points
from caricli.structures.landmarks import POINT_NAMES
from caricli.studio.modes.face_mode import FaceMode
from tests.studio.conftest import run_apart


@pytest.fixture
def mode(head_template):
    """A mode without its page, both sides switched on. done: the operations that it asked for."""
    done: list[Any] = []

    async def do(operation):
        done.append(operation)

    tools = SimpleNamespace(model=SimpleNamespace(template=head_template))
    page: Any = SimpleNamespace(do=do, studio=SimpleNamespace(tools=tools))
    own: Any = FaceMode(page)
    own.mirrored = own.symmetric = SimpleNamespace(value=True)
    own.done = done
    return own


@pytest.mark.parametrize("name", POINT_NAMES)
def test_points_of_the_middle_are_pulled_aside_alone(mode, head_template, name):
    mode.point = SimpleNamespace(value=name)
    mode.lengths = [SimpleNamespace(value=value) for value in (5, 0, None)]
    run_apart(mode._pull_named())
    (operation,) = mode.done
    parameters = operation.parameters
    handles = handle_points([*parameters["handles"].items()], (), head_template, parameters["symmetric"])
    sides = "left" in name or "right" in name
    assert parameters["symmetric"] == sides and len(handles.vertices) == 1 + sides


@pytest.mark.parametrize(
    ("name", "both"),
    [
        ("mouthSmileLeft", ["mouthSmileLeft", "mouthSmileRight"]),
        ("eyeLookInRight", ["eyeLookInLeft", "eyeLookInRight"]),
        ("jawOpen", ["jawOpen"]),
        ("jawLeft", ["jawLeft"]),
        ("mouthRight", ["mouthRight"]),
    ],
)
def test_jaw_and_mouth_go_to_one_side_at_a_time(mode, name, both):
    assert [*mode._expression(name, 0.5).parameters["weights"]] == both


def test_a_slider_that_is_let_go_is_not_tried_once_more(mode):
    tried: list[Any] = []

    async def do(operation):
        # What a hand did last comes after it let go, as messages of a moving slider are held back.
        await mode._slide("BigNose", 1.0)

    mode.locks = {"BigNose": SimpleNamespace(value=False)}
    mode.sliding = asyncio.Lock()
    mode.page.do = do
    mode.page.attempt = tried.append
    mode.page.desk = SimpleNamespace(history=SimpleNamespace(work=SimpleNamespace(strengths={})))
    run_apart(mode._slid("BigNose", 1.0))
    assert not tried
    run_apart(mode._slide("BigNose", 1.0))
    assert len(tried) == 1


def test_a_slider_that_is_dragged_away_and_back_shows_the_work(mode):
    played: list[str] = []

    async def forget():
        played.append("work")

    mode.locks = {"BigNose": SimpleNamespace(value=False)}
    mode.sliding = asyncio.Lock()
    mode.page.forget = forget
    mode.page.attempt = lambda operation: played.append("tried")
    mode.page.desk = SimpleNamespace(history=SimpleNamespace(work=SimpleNamespace(strengths={})))
    for value in (1.0, 0.0):
        run_apart(mode._slide("BigNose", value))
    assert played == ["tried", "work"]
