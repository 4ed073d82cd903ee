from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.parts.attachment import open_head_attachment
from caricli.methods.parts.incisors import BEHIND, CROWN, LAUGHED, LOWER, SHOWN, incisors_of
from caricli.structures import Material, Mesh, Part

NONE = np.zeros((0, 4200, 3))


@pytest.fixture(scope="module")
def laughing(head, head_template):
    """A face whose upper lip is drawn up, and whose jaw is open."""
    names = list(head.action_names)
    ways = {"jawOpen": 0.5, "mouthUpperUpLeft": 1.0, "mouthUpperUpRight": 1.0}
    return head_template.vertices + sum(weight * head.actions[names.index(name)] for name, weight in ways.items())


def upper_teeth(template, vertices, given=None):
    parts = open_head_attachment().animate(template.with_vertices(vertices), {}, NONE, given)
    part = next(part for part in parts if part.name == "teeth_upper")
    incisors = incisors_of(template, part)
    crown = np.ptp(part.mesh.vertices[incisors.front, 1])
    upper, lower = vertices[incisors.lips, 1]
    return upper - incisors.edge(part.mesh.vertices, np.array([0.0, 1, 0])), upper - lower, crown


def test_an_open_mouth_shows_the_upper_teeth(head_template, laughing):
    shown, opening, crown = upper_teeth(head_template, laughing)
    assert opening > 0.01 and shown > 0.95 * min(SHOWN * opening, CROWN * crown)


def test_behind_closed_lips_they_are_where_the_skull_has_them(head_template):
    shown, _, _ = upper_teeth(head_template, head_template.vertices)
    assert -BEHIND * head_template.height <= shown < 0


@pytest.mark.parametrize("sunk", [0.03, -0.03])
def test_lower_teeth_end_near_their_lip_when_lips_meet(head_template, sunk):
    part = next(hold.part for hold in open_head_attachment().holds if hold.part.name == "teeth_lower")
    incisors, shape = incisors_of(head_template, part), np.asarray(part.mesh.vertices, float)
    assert incisors is not None
    up = np.array([0.0, 1, 0])
    moved = shape - sunk * head_template.height * up
    skin, height = head_template.vertices, head_template.height
    lifted = moved + incisors.lifted(skin, moved, up, height) * up
    above = (incisors.edge(lifted, up) - skin[incisors.lips[1], 1]) / height
    assert abs(above - LOWER[int(sunk < 0)]) < 1e-3
    assert incisors.lifted(skin, shape, up, height) == 0


def test_those_that_a_laugh_drew_up_come_down_when_the_lips_close(head_template):
    """A neutral face in which they were too high, and which was found from a face that showed them."""
    high = head_template.vertices.copy()
    wall = head_template.annotation.regions["inner_mouth"]
    lips = np.concatenate([head_template.annotation.curves[f"mouth_inner_{side}"] for side in ("upper", "lower")])
    high[np.setdiff1d(wall, lips), 1] += 0.03 * head_template.height
    hidden, opening, _ = upper_teeth(head_template, high)
    laugh = high.copy()
    laugh[head_template.annotation.curves["mouth_inner_lower"], 1] -= 0.05 * head_template.height
    shown, _, _ = upper_teeth(head_template, high, laugh)
    assert hidden < shown <= (LAUGHED + 0.002) * head_template.height and opening < 0.002 * head_template.height


@pytest.mark.parametrize("shown", [0.0, 0.01, 0.02])
def test_teeth_end_where_a_picture_shows_it(head_template, laughing, shown):
    mesh = head_template.with_vertices(laughing)
    up = np.array([0.0, 1, 0])
    usual = {part.name: part for part in open_head_attachment().attach(mesh)}
    teeth = np.array([shown, 0.004])
    for part in open_head_attachment().animate(mesh, {}, NONE, teeth=teeth)[:2]:
        incisors = incisors_of(head_template, part)
        before, now = usual[part.name].mesh.vertices, part.mesh.vertices
        beyond = incisors.outwards * (incisors.edge(now, up) - laughing[incisors.lips[incisors.row], 1])
        wanted = teeth[incisors.row] or -BEHIND * head_template.height
        # The wall of the mouth pushes lower ones up a little.
        assert abs(beyond - wanted) < (0.002, 0.004)[incisors.row], part.name
        growth = np.ptp(now[incisors.front, 1]) / np.ptp(before[incisors.front, 1])
        assert (growth > 1.5) == (wanted == 0.02), part.name


def test_long_teeth_lean_as_the_lips_do(head_template, laughing):
    part = next(hold.part for hold in open_head_attachment().holds if hold.part.name == "teeth_upper")
    incisors, shape = incisors_of(head_template, part), part.mesh.vertices
    assert incisors is not None
    up = np.array([0.0, 1, 0])
    overhung = laughing.copy()
    overhung[incisors.lips[1], 2] -= 0.01
    straight, leaning = (
        incisors.as_pictured(skin, shape, up, 0.02, head_template.height) for skin in (laughing, overhung)
    )
    back = (straight - leaning)[incisors.front, 2]
    lowest = straight[incisors.front, 1].argmin()
    assert 0.006 < back[lowest] < 0.0076 and back.min() >= 0 and np.isclose(back.max(), back[lowest])


@pytest.mark.parametrize("name", ["teeth_upper", "teeth_lower"])
def test_teeth_that_a_picture_does_not_show_go_behind_their_lip_and_never_before_it(head_template, laughing, name):
    part = next(hold.part for hold in open_head_attachment().holds if hold.part.name == name)
    incisors, shape = incisors_of(head_template, part), part.mesh.vertices
    assert incisors is not None
    up = np.array([0.0, 1, 0])
    hidden = incisors.as_pictured(laughing, shape, up, 0.0, head_template.height)
    beyond = incisors.outwards * (incisors.edge(hidden, up) - laughing[incisors.lips[incisors.row]] @ up)
    assert beyond < 0
    deeper = hidden - 0.01 * incisors.outwards * up
    np.testing.assert_array_equal(incisors.as_pictured(laughing, deeper, up, 0.0, head_template.height), deeper)


def test_long_teeth_keep_their_gums_and_their_edges(head_template):
    """Gums go up as they are, not stretched between the teeth, and every tooth ends where it did."""
    part = next(hold.part for hold in open_head_attachment().holds if hold.part.name == "teeth_upper")
    incisors, shape = incisors_of(head_template, part), np.asarray(part.mesh.vertices, float)
    assert incisors is not None
    grown = incisors.grown(shape, np.array([0.0, 1, 0]), 0.02, 4.0)
    gums = np.unique(part.mesh.polygons[part.materials == Material.GUMS])
    moved = (grown - shape)[:, 1]
    crowns = incisors.teeth.reshape(14, -1)
    longer = np.ptp(grown[crowns, 1], axis=1) - np.ptp(shape[crowns, 1], axis=1)
    assert moved.max() > 0.012 and moved[gums].min() > 0.7 * moved.max() and longer.min() > 0.6 * moved.max()
    assert (grown[crowns, 1].min(1) - shape[crowns, 1].min(1)).max() < 0.15 * moved.max()


def test_gums_go_up_where_a_tooth_is_lost(head_template):
    """Between canines, where an arch has none."""
    part = next(hold.part for hold in open_head_attachment().holds if hold.part.name == "teeth_upper")
    crowns = np.unique(part.mesh.polygons[part.materials == Material.TEETH]).reshape(14, -1)
    kept = np.isin(part.mesh.polygons, crowns[[0, 5, 8, 13]]).any(1)
    incisors = incisors_of(head_template, replace(part, materials=np.where(kept, part.materials, Material.GUMS)))
    assert incisors is not None
    shape = np.asarray(part.mesh.vertices, float)
    moved = (incisors.grown(shape, np.array([0.0, 1, 0]), 0.02, 4.0) - shape)[:, 1]
    gums = np.unique(part.mesh.polygons[part.materials == Material.GUMS])
    middle = gums[incisors.aside[gums] < 0.03]
    assert moved[middle].min() > 0 and np.isclose(moved[middle].max(), moved.max()) and moved.max() > 0.012


def test_teeth_between_lips_that_meet_stay_finite(head_template):
    part = next(hold.part for hold in open_head_attachment().holds if hold.part.name == "teeth_upper")
    incisors, shape = incisors_of(head_template, part), part.mesh.vertices
    assert incisors is not None
    shut = head_template.vertices.copy()
    shut[incisors.lips[1]] = shut[incisors.lips[0]]
    teeth = incisors.as_pictured(shut, shape, np.array([0.0, 1, 0]), 0.02, head_template.height)
    assert np.isfinite(teeth).all() and np.abs(teeth - shape).max() < 0.06


@pytest.mark.parametrize("across", [(0.0,), (-0.012, 0.012)], ids=["one tooth", "fangs"])
@pytest.mark.parametrize("depth", [0.004, 0.0])
def test_teeth_of_few_vertices_end_where_the_lowest_of_them_are(head_template, across, depth):
    box = np.stack(np.meshgrid([-0.004, 0.004], [0.0, 0.01], [0.0, depth], indexing="ij"), -1).reshape(-1, 3)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6]])
    vertices = np.concatenate([box + [x, 0.075, 0.12] for x in across])
    mesh = Mesh(vertices, np.concatenate([quads + 8 * k for k in range(len(across))]))
    materials = np.full(len(mesh.polygons), Material.TEETH, np.int32)
    fangs = Part("teeth_upper", mesh, materials, "skull", (), np.zeros((0, len(vertices), 3)))
    incisors = incisors_of(head_template, fangs)
    assert incisors is not None and incisors.edge(vertices, np.array([0.0, 1, 0])) == pytest.approx(0.075)


def test_what_has_no_teeth_has_no_incisors(head_template):
    tongue = next(hold.part for hold in open_head_attachment().holds if hold.part.name == "tongue")
    assert incisors_of(head_template, tongue) is None
