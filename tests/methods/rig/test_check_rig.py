from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.rig.check_rig import check_rig, nearest_arkit
from caricli.structures import Mesh, Rig
from caricli.structures.arkit import ARKIT_NAMES


def test_arkit_names_are_those_of_the_head(head):
    assert len(ARKIT_NAMES) == 52 and set(ARKIT_NAMES) == set(head.action_names)


@pytest.fixture
def ball_rig(ball):
    """A ball of 0.2 m with shapes: a push, nothing but rounding, a cap turned inside out."""
    vertices, faces = ball
    neutral = (0.1 * vertices).astype(np.float32)
    deltas = np.zeros((3, *neutral.shape), np.float32)
    deltas[0, :40, 1] = 0.01
    deltas[0, 7, 1] = -0.03
    deltas[1, 3] = 3e-7
    cap = neutral[:, 2] > 0.08
    deltas[2, cap, 0] = -2 * neutral[cap, 0]
    return Rig(("jawOpen", "tongue_out", "extra"), Mesh(neutral, faces), deltas)


def test_a_rig_is_described(ball_rig):
    check = check_rig(ball_rig)
    assert (check.exact, check.near, check.unknown) == (("jawOpen",), {"tongue_out": "tongueOut"}, ("extra",))
    assert check.missing == tuple(name for name in ARKIT_NAMES if name not in ("jawOpen", "tongueOut"))
    push, nothing, turned = check.shapes
    assert [shape.name for shape in check.shapes] == list(ball_rig.names)
    assert (push.largest, push.moved, push.empty) == (pytest.approx(0.03), 40, False)
    assert (nothing.largest, nothing.moved, nothing.flipped, nothing.empty) == (
        pytest.approx(3e-7 * 3**0.5),
        0,
        0,
        True,
    )
    assert turned.moved == (ball_rig.neutral[:, 2] > 0.08).sum()
    assert 0 < turned.flipped < 0.2


def test_flips_are_left_open_where_triangles_have_no_area(ball_rig):
    flat = ball_rig.neutral.copy()
    flat[ball_rig.faces[0, 1]] = flat[ball_rig.faces[0, 0]]
    check = check_rig(replace(ball_rig, mesh=ball_rig.mesh.with_vertices(flat)))
    assert [shape.flipped for shape in check.shapes] == [None] * 3
    assert check.shapes[0].moved == 40


@pytest.mark.parametrize("name", ARKIT_NAMES)
def test_every_usual_spelling_leads_to_the_name(name):
    short = name.removesuffix("Left") + "_L" if name.endswith("Left") else name
    short = name.removesuffix("Right") + "R" if name.endswith("Right") else short
    spaced = "".join(f" {c.lower()}" if c.isupper() else c for c in name)
    spellings = [name, name[0].upper() + name[1:], name.upper(), short, spaced, spaced.replace(" ", "_")]
    spellings += ["blendShape1." + name, "Face:" + name, name[:4] + name[5:] if len(name) > 12 else name]
    assert {spelling: nearest_arkit(spelling) for spelling in spellings} == dict.fromkeys(spellings, name)


@pytest.mark.parametrize("name", ["_neutral", "Basis", "smile", "viseme_aa", "jaw", "nose_L", "", "..", "L"])
def test_other_names_lead_nowhere(name):
    assert nearest_arkit(name) is None
