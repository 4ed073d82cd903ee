import numpy as np
import pytest

from caricli.methods.sketch.follow_lines import LineFollower
from caricli.methods.sketch.settings import FollowSettings


@pytest.fixture(scope="module")
def follower(model, handles):
    return LineFollower(model.template, handles)


@pytest.fixture(scope="module")
def own(model, handles, camera):
    return camera.project(model.template.vertices[handles.vertices])


def test_handles_go_to_their_places_at_their_depth(follower, model, handles, camera, own):
    wanted = own + np.random.default_rng(0).normal(0, 1, own.shape)
    moved = follower.follow(model.template.vertices, camera, wanted)
    assert np.linalg.norm(camera.project(moved[handles.vertices]) - wanted, axis=1).mean() < 0.3
    depth = (moved - model.template.vertices) @ camera.rotation[2]
    assert np.abs(depth).max() < 1e-12


def test_what_is_common_moves_all(follower, model, camera, own):
    moved = follower.follow(model.template.vertices, camera, own + [5, -3])
    way = camera.project(moved) - camera.project(model.template.vertices)
    np.testing.assert_allclose(way, np.broadcast_to([5.0, -3], way.shape), atol=1e-6)


def test_handles_of_which_nothing_was_drawn_feel_no_force(follower, model, handles, camera, own):
    """The same as a system that has the other handles alone."""
    drawn = np.zeros(len(own), bool)
    drawn[handles.rows["mouth_lower"]] = drawn[handles.rows["nose"]] = True
    places = np.where(drawn[:, None], own + [0, 6.0], np.nan)
    places[handles.rows["nose"]] = own[handles.rows["nose"]]
    moved = follower.follow(model.template.vertices, camera, places)

    from caricli.geometry.deformation.laplacian_deformation import LaplacianDeformation

    ids = handles.vertices[drawn]
    alone = LaplacianDeformation(model.template.vertices, model.template.faces, ids, FollowSettings().weight)
    goals = camera.lift(places[drawn], model.template.vertices[ids])
    np.testing.assert_allclose(moved, alone.move(goals, rounds=0), atol=1e-6)


def test_without_lines_nothing_moves(follower, model, camera, own):
    assert follower.follow(model.template.vertices, camera, np.full_like(own, np.nan)) is model.template.vertices
