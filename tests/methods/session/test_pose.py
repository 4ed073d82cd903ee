from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.rig.add_eyeballs import eye_turns
from caricli.methods.session.pose import Poser
from caricli.methods.session.pull_basis import dressed_vertices, pull_basis


@pytest.fixture(scope="module")
def poser(tools):
    return Poser(tools)


def placed(poser, work):
    """Vertices of parts by their names."""
    return {part.name: part.mesh.vertices for part in poser.parts(work)}


def test_teeth_and_lashes_go_with_the_expression_and_come_back(poser, start):
    rest = placed(poser, start)
    assert {"teeth_upper", "teeth_lower", "tongue", "lashes"} <= set(rest)
    opened = placed(poser, replace(start, weights={"jawOpen": 1.0}))
    assert (opened["teeth_lower"] - rest["teeth_lower"])[:, 1].mean() < -0.005
    assert np.abs(opened["teeth_upper"] - rest["teeth_upper"]).max() < 5e-4
    shut = placed(poser, replace(start, weights={"jawOpen": 0.5, "eyeBlinkLeft": 1.0}))
    np.testing.assert_allclose(
        shut["teeth_lower"] - rest["teeth_lower"], 0.5 * (opened["teeth_lower"] - rest["teeth_lower"]), atol=3e-4
    )
    assert np.abs(shut["lashes"] - rest["lashes"]).max() > 0.003
    again = placed(poser, start)
    assert all(np.array_equal(again[name], rest[name]) for name in rest)
    assert poser.vertices(start) is start.face.vertices


def test_lids_squint_only_as_far_as_a_blink_leaves_them_open(poser, start):
    blink = poser.vertices(replace(start, weights={"eyeBlinkLeft": 1.0}))
    both = replace(start, weights={"eyeSquintLeft": 1.0, "eyeBlinkLeft": 1.0})
    np.testing.assert_allclose(poser.vertices(both), blink, atol=1e-9)
    squint = poser.vertices(replace(start, weights={"eyeSquintLeft": 1.0}))
    assert np.abs(squint - start.face.vertices).max() > 1e-3


def test_lips_of_a_closed_jaw_have_nothing_to_close(poser, start):
    np.testing.assert_allclose(poser.vertices(replace(start, weights={"mouthClose": 1.0})), start.face.vertices)


def test_another_face_has_its_own_expressions_and_parts(poser, start):
    laughing = replace(start, weights={"jawOpen": 1.0})
    before = poser.vertices(laughing)
    wide = replace(laughing, face=start.face.with_vertices(start.face.vertices * [1.2, 1, 1]))
    assert not np.allclose(poser.vertices(wide) - wide.face.vertices, before - start.face.vertices, atol=1e-4)
    breadths = [np.ptp(placed(poser, work)["teeth_upper"][:, 0]) for work in (laughing, wide)]
    assert breadths[1] > 1.1 * breadths[0]
    np.testing.assert_array_equal(poser.vertices(laughing), before)


def test_eyes_turn_as_rigs_have_it(start):
    """In is towards the nose, down is positive about x, to the subject's left positive about y."""
    weights = {"eyeLookInLeft": 1.0, "eyeLookUpLeft": 0.5, "eyeLookInRight": 0.5, "eyeLookDownRight": 1.0}
    turns = np.degrees(eye_turns(weights))
    np.testing.assert_allclose(turns, [[-30, -11], [15, 25]])
    assert not eye_turns({}).any()


def test_parts_follow_a_point_that_is_dragged(tools, start, head_template):
    upper_lip = str(head_template.annotation.landmarks[51])
    ways = pull_basis(start, upper_lip, tools)
    assert ways.shape == (3, *dressed_vertices(start.face, tools).shape)
    assert ways[1, int(upper_lip), 1] == pytest.approx(1, abs=0.05)
    count = len(start.face.vertices)
    assert np.abs(ways[1, count:]).max() > 0.01 and np.abs(ways).max() < 3
