import igl
import numpy as np
import pytest

from caricli.geometry.deformation.elastic_anchors import (
    SPREAD_LENGTH,
    STIFFNESS_LENGTH,
    ElasticAnchors,
    surrounding_averages,
)

POINTS = np.array([5, 40, 18, 57, 33, 9])
EXACT = 1e6


@pytest.fixture(scope="module")
def anchors(patch):
    return ElasticAnchors(*patch, POINTS)


def pulls(count, seed=0):
    return np.random.default_rng(seed).normal(0, 0.1, (count, 3))


def dense_averages(vertices, laplacian, mass, points):
    length = SPREAD_LENGTH * np.ptp(vertices[:, 1])
    spread = mass @ np.linalg.inv(mass + length**2 / 2 * laplacian)[:, points]
    return (spread / spread.sum(0)).T


def dense_move(vertices, faces, points, moves, weights):
    """The stated energy in dense matrices, minimised by np.linalg.solve."""
    laplacian = -igl.cotmatrix(vertices, faces).toarray()
    mass = igl.massmatrix(vertices, faces).toarray()
    averages = dense_averages(vertices, laplacian, mass, points)
    length = STIFFNESS_LENGTH * np.ptp(vertices[:, 1])
    plate = laplacian + length**2 * laplacian @ np.linalg.inv(mass) @ laplacian
    weighted = averages.T * (weights * np.diag(laplacian).mean())
    return np.linalg.solve(plate + weighted @ averages, weighted @ moves)


@pytest.mark.parametrize("strength", [0.01, 1.0, 100.0])
def test_the_dense_minimiser_of_the_energy_agrees(patch, anchors, strength):
    confidence = np.array([1.0, 0.3, 0.8, 0.05, 1.0, 0.5])
    moves = pulls(6)
    expected = dense_move(*patch, POINTS, moves, strength * confidence)
    assert np.abs(anchors.move(POINTS, moves, strength, confidence) - expected).max() < 1e-6


def test_large_strength_is_exact_where_the_surroundings_are_counted(patch, anchors):
    moves = pulls(6)
    averages = surrounding_averages(*patch, POINTS)
    moved = anchors.move(POINTS, moves, EXACT)
    assert np.abs(averages @ moved - moves).max() < 1e-5
    assert np.abs(averages @ anchors.move(POINTS, moves, 0.01) - moves).max() > 1e-2


def test_what_was_solved_before_is_not_solved_again(patch, anchors, monkeypatch):
    monkeypatch.setattr("caricli.geometry.deformation.elastic_anchors.Cholesky", None)
    again = ElasticAnchors(*patch, POINTS, anchors.solved)
    np.testing.assert_array_equal(again.move(POINTS, pulls(6), 2.0), anchors.move(POINTS, pulls(6), 2.0))


def test_a_common_translation_moves_everything_alike_whatever_the_strength(patch, anchors):
    shift = np.array([0.3, -0.2, 0.1])
    for strength in (1e-3, 1.0, EXACT):
        moved = anchors.move(POINTS, np.tile(shift, (6, 1)), strength)
        assert moved.shape == patch[0].shape
        assert np.abs(moved - shift).max() < 1e-9


def test_one_anchor_alone_translates_the_surface(anchors):
    assert np.abs(anchors.move(POINTS[:1], pulls(1), 1.0) - pulls(1)).max() < 1e-9


def test_a_subset_in_any_order_acts_as_if_nothing_else_were_prepared(patch, anchors):
    chosen = POINTS[[4, 1, 2]]
    expected = ElasticAnchors(*patch, np.sort(chosen)).move(chosen, pulls(3), 2.0)
    assert np.abs(anchors.move(chosen, pulls(3), 2.0) - expected).max() < 1e-9
    assert np.abs(anchors.move(chosen[::-1], pulls(3)[::-1], 2.0) - expected).max() < 1e-9


def test_a_point_that_was_not_prepared_is_an_error(anchors):
    with pytest.raises(KeyError):
        anchors.move(np.array([0]), pulls(1), 1.0)


def test_confidence_multiplies_the_strength(anchors):
    moves = pulls(6)
    half = anchors.move(POINTS, moves, 2.0, np.full(6, 0.5))
    assert np.abs(half - anchors.move(POINTS, moves, 1.0)).max() < 1e-12


def test_an_anchor_without_confidence_drops_out(anchors):
    confidence = np.array([1, 1, 1, 1e-9, 1, 1])
    kept = [0, 1, 2, 4, 5]
    expected = anchors.move(POINTS[kept], pulls(6)[kept], 1.0)
    assert np.abs(anchors.move(POINTS, pulls(6), 1.0, confidence) - expected).max() < 1e-6


def test_moves_along_one_axis_are_those_of_that_axis(anchors):
    moves = pulls(6)
    assert np.allclose(anchors.move(POINTS, moves[:, :1], 1.0), anchors.move(POINTS, moves, 1.0)[:, :1], atol=1e-12)


def test_inputs_are_left_alone(anchors):
    moves, confidence = pulls(6), np.full(6, 0.5)
    anchors.move(POINTS, moves, 1.0, confidence)
    assert np.array_equal(moves, pulls(6)) and np.array_equal(confidence, np.full(6, 0.5))


@pytest.mark.parametrize("landmark", [4, 8, 19, 30, 48, 51])
def test_a_pulled_landmark_is_no_spike(head_template, landmark):
    """Jaw, chin, brow, nose tip, mouth corner, upper lip; all others but the nearest ones are held."""
    vertices, faces = head_template.vertices, head_template.faces
    landmarks = head_template.annotation.landmarks
    point = landmarks[landmark]
    distance = np.linalg.norm(vertices - vertices[point], axis=1)
    held = landmarks[(distance[landmarks] > 0.025) | (landmarks == point)]
    moves = np.where(held == point, 0.01, 0.0)[:, None] * [0.0, 0.0, 1.0]
    moved = ElasticAnchors(vertices, faces, held).move(held, moves, EXACT)[:, 2]
    ring = np.setdiff1d(faces[(faces == point).any(1)], point)
    assert 0.8 * 0.01 < moved[point] < 1.3 * 0.01
    assert np.abs(moved).max() < 1.3 * 0.01
    # A neighbour 6 mm away makes at least 70 % of the move.
    assert (moved[ring] > (1 - 50 * distance[ring]) * moved[point]).all()


def test_averages_stay_on_their_side_of_a_gap():
    """Two sheets that lie on each other: the spread of a point follows the surface, not the distance."""
    y, x = np.mgrid[:8, :8] / 7.0
    sheet = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    corner = (np.arange(7)[:, None] * 8 + np.arange(7)).ravel()
    quads = np.stack([corner, corner + 1, corner + 9, corner + 8], axis=1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    faces = np.concatenate([faces, faces + 64])
    vertices = np.concatenate([sheet, sheet + [0, 0, 1e-3]])
    averages = surrounding_averages(vertices, faces, np.array([27]))[0]
    assert averages[:64].sum() == pytest.approx(1.0)
    assert np.abs(averages[64:]).max() < 1e-12
    assert averages.argmax() == 27


def test_confidence_has_directions(anchors):
    confidence = np.array([1.0, 0.3, 0.8, 0.05, 1.0, 0.5])
    moves = pulls(6)
    same = anchors.move(POINTS, moves, 2.0, confidence[:, None, None] * np.eye(3))
    np.testing.assert_allclose(same, anchors.move(POINTS, moves, 2.0, confidence), atol=1e-9)
    # Each axis by itself, where the directions are the axes.
    weights = np.random.default_rng(1).uniform(0.05, 1, (6, 3))
    apart = anchors.move(POINTS, moves, 2.0, weights[:, None] * np.eye(3))
    for k in range(3):
        np.testing.assert_allclose(apart[:, k], anchors.move(POINTS, moves, 2.0, weights[:, k])[:, k], atol=1e-9)
    # A turn of all turns the result.
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turned = anchors.move(POINTS, moves @ turn.T, 2.0, turn @ (weights[:, None] * np.eye(3)) @ turn.T)
    np.testing.assert_allclose(turned, apart @ turn.T, atol=1e-9)
