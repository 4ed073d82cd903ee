from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.rig.add_eyeballs import Eyeball
from caricli.methods.rig.make_rig import RigResult
from caricli.methods.rig.measure_rig import RigMeasures
from caricli.methods.rig.rig_figures import describe_rig, lips_are_apart, rig_figures
from caricli.structures import Mesh, Rig
from caricli.template.fine_mesh import fine_mesh


@pytest.fixture
def result(ball):
    vertices, faces = ball
    rig = Rig(("jawOpen", "nothing"), Mesh(vertices.astype(np.float32), faces), np.zeros((2, 300, 3), np.float32))
    measures = RigMeasures(
        flipped=np.array([0.001, 0]),
        strength=np.array([0.9, np.nan]),
        contact_gap=np.array([np.nan, np.nan]),
        lid_gap={"left": 0.01, "right": 0.004},
        lip_gap=0.05,
        lips_open=0.2,
        inside=-0.001,
    )
    return RigResult(rig, measures, [Eyeball("left", np.zeros(3), 0.01, 0.0)], fine_mesh(rig.mesh, 0), lambda face: [])


def test_what_is_not_a_number_is_left_out(result):
    figures = rig_figures(result, {"jawOpen": {"action_units": ["AU26"]}})
    assert figures["expressions"] == {
        "jawOpen": {"strength": 0.9, "flipped": 0.001, "action_units": ["AU26"]},
        "nothing": {"flipped": 0.0},
    }
    assert figures["lip_gap"] == 0.05 and figures["lids_inside_eyeballs"] == -0.001
    assert figures["eyeballs"][0]["side"] == "left"
    bare = replace(result, measures=replace(result.measures, lid_gap={}, lip_gap=None, inside=None), eyeballs=[])
    assert set(rig_figures(bare, {})) == {"expressions", "eyeballs"}


def test_the_line(result):
    expected = (
        "2 expressions (1 move), 300 vertices, lids close to 1.0 %, lips to 5.0 %, flipped triangles at most 0.100 %"
    )
    assert describe_rig(result) == expected
    assert lips_are_apart(result)
    assert not lips_are_apart(replace(result, measures=replace(result.measures, lips_open=None)))
