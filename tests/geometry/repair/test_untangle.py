import numpy as np
import pytest
from scipy.sparse.csgraph import shortest_path
from scipy.spatial.transform import Rotation

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import _around, untangle
from caricli.geometry.vertex_neighbours import vertex_neighbours


def pushed(vertices, faces, face):
    a, b, c = faces[face]
    moved = vertices.copy()
    moved[a] += 1.4 * ((vertices[b] + vertices[c]) / 2 - vertices[a])
    return moved


def crumpled(vertices, size, seed=0):
    return vertices + np.random.default_rng(seed).normal(0, size, vertices.shape)


def test_a_shape_without_flipped_triangles_comes_back_as_it_is(ball_gradients):
    shape = ball_gradients.template * [1.0, 2.0, 0.5]
    assert untangle(shape, ball_gradients) is shape


@pytest.mark.parametrize("face", [10, 300, 590])
def test_a_triangle_turned_over_turns_back_and_far_vertices_stay(ball_gradients, face):
    vertices, faces = ball_gradients.template, ball_gradients.faces
    shape = pushed(vertices, faces, face)
    before = shape.copy()
    repaired = untangle(shape, ball_gradients)
    assert flipped_triangles(shape, ball_gradients).sum() == 1
    assert not flipped_triangles(repaired, ball_gradients).any()
    assert np.array_equal(shape, before)
    corner = faces[face, 0]
    far = np.linalg.norm(vertices - vertices[corner], axis=1) > 1.2
    shift = np.linalg.norm(shape[corner] - vertices[corner])
    assert np.linalg.norm((repaired - shape)[far], axis=1).max() < 0.05 * shift
    assert np.linalg.norm(repaired[corner] - shape[corner]) > 0.2 * shift


def test_a_crumpled_shape_gets_no_worse(ball_gradients):
    shape = ball_gradients.template + np.random.default_rng(0).normal(0, 0.1, ball_gradients.template.shape)
    before = flipped_triangles(shape, ball_gradients).sum()
    after = flipped_triangles(untangle(shape, ball_gradients), ball_gradients).sum()
    assert 0 < before and after < before


def test_without_rounds_nothing_is_done(ball_gradients):
    shape = pushed(ball_gradients.template, ball_gradients.faces, 10)
    assert np.array_equal(untangle(shape, ball_gradients, rounds=0), shape)


def test_a_head_with_shut_eyes_and_flips_gets_better(head, head_template):
    shape = head.evaluate(changes={"mouth-scale-horiz-incr": -1.5}, actions={"mouthClose": 1.0, "eyeBlinkLeft": 1.3})
    gradients = head_template.gradients
    before = flipped_triangles(shape, gradients).sum()
    repaired = untangle(shape, gradients)
    assert 0 < before and flipped_triangles(repaired, gradients).sum() < before
    away = head_template.region("scalp")
    assert np.linalg.norm((repaired - shape)[away], axis=1).mean() < 1e-3


def test_of_an_edit_kinks_go_and_the_edit_stays(ball, ball_gradients):
    vertices, _ = ball
    top = int(vertices[:, 2].argmax())
    away = np.linalg.norm(vertices - vertices[top], axis=1)
    edited = vertices + 0.5 * np.exp(-((away / 0.7) ** 2))[:, None] * [0, 0, 1.0]
    beside = int(np.argsort(away)[4])
    edited[beside] += 1.4 * (edited[top] - edited[beside])
    assert flipped_triangles(edited, ball_gradients).sum() > 0
    found = untangle(edited, ball_gradients, 16, vertices)
    assert not flipped_triangles(found, ball_gradients).any()
    moved = found[:, 2] - vertices[:, 2]
    assert moved[top] - moved[away > 1.5].mean() > 0.4


def test_what_was_flipped_before_an_edit_is_left_as_it_is(ball_gradients):
    before = pushed(ball_gradients.template, ball_gradients.faces, 10)
    edited = before * [1.0, 1.1, 1.0]
    assert untangle(edited, ball_gradients, before=before) is edited
    both = pushed(edited, ball_gradients.faces, 300)
    found = untangle(both, ball_gradients, before=before)
    assert np.flatnonzero(flipped_triangles(found, ball_gradients)).tolist() == [10]
    corners = ball_gradients.faces[10]
    np.testing.assert_allclose(
        found[corners] - found[corners].mean(0), both[corners] - both[corners].mean(0), atol=0.01
    )


def _hopeless(shape, gradients):
    """Flipped at face 10, whatever is done."""
    return np.arange(len(gradients.faces)) == 10


def test_a_shape_that_gets_no_better_comes_back_as_it_was(ball_gradients, monkeypatch):
    monkeypatch.setattr("caricli.geometry.repair.untangle.flipped_triangles", _hopeless)
    shape = crumpled(ball_gradients.template, 0.1)
    assert untangle(shape, ball_gradients) is shape


def test_a_repair_reaches_further_from_round_to_round_where_there_is_a_shape_to_go_back_to(ball_gradients, monkeypatch):
    reached = []

    def around(faces, neighbours, rings):
        reached.append(rings)
        return _around(faces, neighbours, rings)

    monkeypatch.setattr("caricli.geometry.repair.untangle._around", around)
    flips = iter([False, *[True] * 8] + [True] * 8)
    monkeypatch.setattr(
        "caricli.geometry.repair.untangle.flipped_triangles",
        lambda shape, gradients: _hopeless(shape, gradients) & next(flips),
    )
    shape = crumpled(ball_gradients.template, 0.1)
    untangle(shape, ball_gradients, 6, ball_gradients.template)
    assert reached == [3, 6, 9, 12, 12, 12]
    reached.clear()
    untangle(shape, ball_gradients, 6)
    assert reached == [3] * 6


def test_what_a_few_edges_do_not_mend_is_mended_by_more(head_template):
    """A chin turned round, of which three edges around every flipped triangle leave some."""
    gradients = head_template.gradients
    chin = head_template.annotation.regions["chin"]
    edited = head_template.vertices.copy()
    middle = edited[chin].mean(0)
    edited[chin] = (edited[chin] - middle) @ Rotation.from_euler("z", 150, degrees=True).as_matrix().T + middle
    assert flipped_triangles(edited, gradients).sum() > 30
    repaired = untangle(edited, gradients, before=head_template.vertices)
    assert not flipped_triangles(repaired, gradients).any()
    away = head_template.region("scalp")
    assert np.linalg.norm((repaired - edited)[away], axis=1).mean() < 5e-3


@pytest.mark.parametrize("seed", range(3))
def test_an_edit_that_crumples_all_goes_back_until_nothing_is_flipped(ball_gradients, seed):
    before = ball_gradients.template * [1.0, 3.0, 0.5]
    edited = crumpled(before, 0.1, seed)
    assert flipped_triangles(edited, ball_gradients).sum() > 20
    repaired = untangle(edited, ball_gradients, 16, before)
    assert not flipped_triangles(repaired, ball_gradients).any()
    # It goes back to the shape that was edited, not to that of the template.
    apart = repaired - before
    assert np.linalg.norm(apart - apart.mean(0), axis=1).mean() < 0.105


def test_the_reach_of_a_repair_falls_off_from_edge_to_edge(ball_gradients):
    neighbours, _ = vertex_neighbours(ball_gradients.faces, ball_gradients.count)
    face = ball_gradients.faces[[10]]
    edges = shortest_path(neighbours, unweighted=True, indices=face.ravel()).min(0)
    np.testing.assert_allclose(_around(face, neighbours, 3), np.clip(1 - edges / 4, 0, 1))
