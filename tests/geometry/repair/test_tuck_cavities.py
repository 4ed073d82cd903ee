import igl
import numpy as np
import pytest

from caricli.geometry.repair.tuck_cavities import Cavities


def rim_and_inside(faces, region):
    rim = np.intersect1d(region, faces[~np.isin(faces, region).all(1)])
    return rim, np.setdiff1d(region, rim)


def ringed(faces, region):
    """Vertices of a pocket within two edges of its rim, and those farther inside."""
    rim, inside = rim_and_inside(faces, region)
    around = rim
    for _ in range(2):
        around = np.union1d(around, faces[np.isin(faces, around).any(1)])
    return np.intersect1d(inside, around), np.setdiff1d(inside, around)


def outside(vertices, faces, region, ids):
    """Which vertices lie outside the surface that is left when the pocket is cut off and closed by a fan."""
    pocket = np.isin(faces, region).all(1)
    edges = igl.boundary_facets(faces[pocket])[0]
    fan = np.column_stack([edges, np.full(len(edges), len(vertices))])
    closed = np.concatenate([vertices, vertices[np.unique(edges)].mean(0, keepdims=True)])
    return igl.winding_number(closed, np.concatenate([faces[~pocket], fan]), vertices[ids]) < 0.5


def test_a_pocket_that_is_inside_stays_untouched(ball):
    vertices, faces = ball[0].copy(), ball[1]
    pocket = np.flatnonzero(vertices[:, 2] > 0.6)
    vertices[pocket, 2] = 1.2 - vertices[pocket, 2]
    assert not outside(vertices, faces, pocket, rim_and_inside(faces, pocket)[1]).any()
    assert np.array_equal(Cavities(vertices, faces, [pocket]).tuck(vertices), vertices)


def test_without_pockets_nothing_moves(ball):
    assert np.array_equal(Cavities(*ball, []).tuck(ball[0]), ball[0])


@pytest.mark.parametrize("actions", [{}, {"jawOpen": 1.0}, {"mouthPucker": 1.0, "cheekPuff": 1.0}])
def test_a_regular_head_is_left_alone(head, head_template, actions):
    vertices = head.evaluate(actions=actions)
    assert np.array_equal(head_template.cavities.tuck(vertices), vertices)


@pytest.mark.parametrize("forwards", [0.01, 0.03])
def test_a_mouth_cavity_pushed_through_the_lips_goes_back_behind_them(head_template, forwards):
    vertices, faces, cavities = head_template.vertices, head_template.faces, head_template.cavities
    mouth = head_template.region("inner_mouth")
    _, inside = rim_and_inside(faces, mouth)
    pushed = vertices.copy()
    pushed[inside, 2] += forwards
    before = pushed.copy()
    tucked = cavities.tuck(pushed)
    assert np.array_equal(pushed, before)
    # The first rings behind the rim touch the skin by their nature.
    _, deep = ringed(faces, mouth)
    assert outside(pushed, faces, mouth, deep).sum() > 20
    assert not outside(tucked, faces, mouth, deep).any()
    skin = np.setdiff1d(np.arange(len(vertices)), inside)
    assert np.array_equal(tucked[skin], pushed[skin])


def distances(head_template, vertices):
    """Of the deep vertices of the mouth's cavity to the skin, as shares of the head's height."""
    mouth = head_template.region("inner_mouth")
    faces = head_template.faces
    skin = faces[~np.isin(faces, mouth).all(1)]
    points = vertices[ringed(faces, mouth)[1]]
    return np.sqrt(igl.point_mesh_squared_distance(points, vertices, skin)[0]) / head_template.height


@pytest.mark.parametrize("forwards", [0.003, 0.01, 0.03])
def test_a_cavity_that_had_to_move_does_not_shine_through(head_template, forwards):
    pushed = head_template.vertices.copy()
    pushed[rim_and_inside(head_template.faces, head_template.region("inner_mouth"))[1], 2] += forwards
    assert distances(head_template, pushed).min() < 0.006
    assert distances(head_template, head_template.cavities.tuck(pushed)).min() > 0.019


def middles_outside(template, vertices):
    """How many edges of the mouth's cavity, beyond its rim, have their middle in front of the skin."""
    mouth = template.region("inner_mouth")
    edges = igl.edges(template.faces[np.isin(template.faces, mouth).all(1)])
    edges = edges[~np.isin(edges, rim_and_inside(template.faces, mouth)[0]).any(1)]
    more = np.concatenate([vertices, vertices[edges].mean(1)])
    return outside(more, template.faces, mouth, len(vertices) + np.arange(len(edges))).sum()


@pytest.fixture(scope="module", params=[0.01, 0.02])
def grinning(request, head_template):
    """A head whose mouth's cavity comes out above the upper lip, by these metres, right behind its rim."""
    rim, _ = rim_and_inside(head_template.faces, head_template.region("inner_mouth"))
    near, _ = ringed(head_template.faces, head_template.region("inner_mouth"))
    vertices = head_template.vertices.copy()
    vertices[near[vertices[near, 1] > vertices[rim, 1].mean()], 2] += request.param
    return vertices


def test_what_comes_out_near_the_rim_goes_behind_the_skin(head_template, grinning):
    for moved in (head_template.cavities.tuck(grinning), head_template.cavities.withdraw(grinning)):
        assert middles_outside(head_template, grinning) > 20 and not middles_outside(head_template, moved)
        skin = np.setdiff1d(np.arange(len(moved)), head_template.region("inner_mouth"))
        assert np.array_equal(moved[skin], grinning[skin])


def test_triangles_go_behind_skin_that_is_pressed_in_between_their_corners(head_template):
    """Below the nose, by two centimetres."""
    pressed = head_template.vertices.copy()
    nose = pressed[head_template.annotation.landmarks[33]]
    skin = np.setdiff1d(np.arange(len(pressed)), head_template.region("inner_mouth"))
    pressed[skin, 2] -= 0.02 * np.exp(-(((pressed[skin] - nose) / 0.012) ** 2).sum(1))
    assert middles_outside(head_template, pressed) > 20
    for moved in (head_template.cavities.tuck(pressed), head_template.cavities.withdraw(pressed)):
        assert middles_outside(head_template, moved) <= 2


def test_what_is_only_near_the_skin_is_not_withdrawn(head_template):
    pushed = head_template.vertices.copy()
    pushed[rim_and_inside(head_template.faces, head_template.region("inner_mouth"))[1], 2] += 0.003
    assert distances(head_template, pushed).min() < 0.006
    assert np.array_equal(head_template.cavities.withdraw(pushed), pushed)
