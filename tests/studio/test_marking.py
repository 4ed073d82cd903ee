import json

import numpy as np
import pytest

pytest.importorskip("nicegui")

from caricli.errors import NumericsError
from caricli.methods.marks.lay_mean_shape import lay_mean_shape, middle_frame
from caricli.methods.marks.move_marks import switch_off
from caricli.structures import Landmarks
from caricli.studio.marking import Marking

SIZE = (400, 300)


@pytest.fixture(scope="module")
def marking():
    from caricli.store.models import load_model

    return Marking(load_model(kind="intrinsic"))


@pytest.fixture(scope="module")
def laid(marking):
    return lay_mean_shape(marking.model.template, middle_frame(SIZE), SIZE)


def test_the_scene_names_every_point_and_its_group(marking):
    scene = json.loads(json.dumps(marking.scene(81, SIZE, "/here")))
    assert len(set(scene["labels"])) == 81 and scene["src"] == "/here" and scene["size"] == [400, 300]
    assert sorted(k for numbers in scene["groups"].values() for k in numbers) == list(range(81))
    assert all(scene["mirrored"][scene["mirrored"][k]] == k for k in range(81))
    few = marking.scene(68, SIZE, "/here")
    assert len(few["labels"]) == 68 and max(k for numbers in few["groups"].values() for k in numbers) == 67


def test_the_state_holds_points_and_the_face_that_follows(marking, laid):
    state = json.loads(json.dumps(marking.state(switch_off(laid, [30]))))
    assert state["points"][30] is None and state["points"][0] == pytest.approx(laid.points[0].tolist())
    apart = np.linalg.norm(np.array(state["guess"]) - laid.points, axis=1)
    assert apart.mean() < 0.02 * laid.diagonal  # the mean shape fits itself, where it is off, too
    assert np.allclose(state["mirror"], [[-1, 0], [0, 1]], atol=0.01)
    assert len(state["curves"]) > 15 and "seq" not in state
    tried = marking.state(laid, 7)
    assert tried["seq"] == 7 and "mirror" not in tried


def test_points_that_no_face_has_are_shown_without_one(marking, laid, monkeypatch):
    def refuse(*_):
        raise NumericsError("the landmarks do not determine a pose")

    monkeypatch.setattr(marking.chase, "look", refuse)
    state = marking.state(laid)
    assert len(state["points"]) == 81 and not state["curves"] and not state["guess"]
    assert marking.state(laid)["curves"]  # the next look begins anew
    line = np.linspace(10, 200, 81)
    assert len(marking.state(Landmarks(np.stack([line, line], axis=1)))["points"]) == 81
