from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.parts.attachment import Attachment, open_head_attachment
from caricli.methods.parts.flesh import Flesh, Hide
from caricli.methods.parts.let_out import AHEAD, PARTING, far_enough, part_more, tongue_bends, towards_gap
from caricli.structures.arkit import alone
from caricli.template.head import load_head
from caricli.template.head_parts import head_parts

WAY = np.column_stack([np.zeros(20), np.zeros(20), np.linspace(0, 0.03, 20)])
POINTS = np.column_stack([np.tile([-0.01, 0.01], 10), np.repeat([0, 0.004], 10), np.linspace(-0.02, 0, 20)])


def test_a_way_that_ends_behind_the_lips_is_lengthened_smoothly():
    lips = np.array([[0.0, 0.0, 0.04]])
    way, spare = far_enough(POINTS, WAY, lips, 0.25)
    assert abs((POINTS + way)[:, 2].max() - 0.04 - AHEAD * 0.25) < 1e-12 and spare == 0
    assert (np.diff(way[:, 2]) > 0).all() and not way[0].any()


def test_a_way_that_goes_farther_has_some_to_spare():
    way, spare = far_enough(POINTS, WAY, np.array([[0.0, 0.0, 0.01]]), 0.25)
    np.testing.assert_array_equal(way, WAY)
    assert abs(spare - (0.02 - AHEAD * 0.25)) < 1e-12


def test_changes_leave_what_does_not_come_out_and_hang_the_tip():
    bends = tongue_bends(POINTS, WAY, 0.002)
    assert not bends.moves[0].any()
    wished = bends.moves @ bends.wish
    assert wished[-1, 1] < -0.005 and wished[:, 1].argmin() == 19 and not wished[:, [0, 2]].any()
    # Nothing is bounded to be thicker, wider or longer.
    assert (bends.low[np.isfinite(bends.low)] < 0).all()


@pytest.fixture(scope="module")
def tight():
    """A head whose lips leave no way, with what expressions do to it, and what they do when it lets the tongue out."""
    head = load_head()
    template = head.template()
    deltas = head.actions.astype(float)
    face = template.with_vertices(template.vertices * [0.8, 1.0, 1.1])
    return face, head.action_names, deltas, open_head_attachment().let_out(face, alone(head.action_names), deltas)


def test_lips_part_as_far_as_the_tongue_needs(tight):
    face, names, deltas, opened = tight
    k = names.index("tongueOut")
    others = np.arange(len(names)) != k
    np.testing.assert_array_equal(opened[others], deltas[others])
    lips = part_more(names, deltas)
    times = ((opened[k] - deltas[k]) * lips).sum() / (lips**2).sum()
    assert times > 0
    np.testing.assert_allclose(opened[k], deltas[k] + times * lips, atol=1e-9)
    assert {*PARTING} <= {*names}


def test_the_tongue_comes_out_before_the_lips_and_not_through_them(tight):
    face, names, _, opened = tight
    k = names.index("tongueOut")
    parts = {part.name: part for part in open_head_attachment().animate(face, alone([names[k]]), opened[k : k + 1])}
    hide = Hide(face.faces)
    start, way = parts["tongue"].mesh.vertices, parts["tongue"].deltas[0]
    for weight in (0.25, 0.5, 0.75, 1.0):
        flesh = Flesh(hide, face.vertices + weight * opened[k])
        assert flesh.room(start + weight * way)[0].min() > -0.003 * face.height
    curves = face.annotation.curves
    lips = np.concatenate([curves["mouth_inner_upper"], curves["mouth_inner_lower"]])
    assert (start + way)[:, 2].max() > (face.vertices + opened[k])[lips, 2].max() + 0.5 * AHEAD * face.height


def test_a_tip_is_led_into_the_gap_between_the_lips_and_stays_where_it_is_in_it():
    assert towards_gap(POINTS, WAY, 0.01, -0.01) == 0
    for higher in (-0.03, 0.03):
        led = towards_gap(POINTS, WAY, higher + 0.01, higher - 0.01)
        tip = towards_gap(POINTS + [0, led, 0], WAY, higher + 0.01, higher - 0.01)
        assert led * higher > 0 and abs(led) < 0.03 and abs(tip) < 1e-12
    assert tongue_bends(POINTS, WAY, 0.002).start.any() == 0
    assert np.abs(tongue_bends(POINTS, WAY, 0.002, -0.01).start).sum() == 0.01


def test_a_tongue_that_lies_above_the_lips_comes_out_between_them():
    head = load_head()
    template, names = head.template(), head.action_names
    k = names.index("tongueOut")
    jaw, tongue = (part for part in head_parts(head, "natural") if part.hangs_on == "jaw")
    high = replace(tongue, mesh=tongue.mesh.with_vertices(tongue.mesh.vertices + [0, 0.012, 0]))
    actions = head.actions.astype(float)
    attachment = Attachment(template, [jaw, high], actions=actions)
    deltas = attachment.let_out(template, alone(names), actions)
    out = attachment.animate(template, alone([names[k]]), deltas[k : k + 1])[1]
    ends = out.mesh.vertices + out.deltas[0]
    upper = template.annotation.curves["mouth_inner_upper"]
    skin = template.vertices + deltas[k]
    assert ends[ends[:, 2].argmax(), 1] < skin[upper, 1].max()
    assert Flesh(Hide(template.faces), skin).room(ends)[0].min() > 0
