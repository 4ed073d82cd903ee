from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.stats import multivariate_t

from caricli.methods.train.detector.detector_losses import (
    TAILS,
    FaceTargets,
    _apart,
    _doubt,
    face_loss,
    landmark_loss,
    region_loss,
)
from caricli.models.detector.config import DetectorConfig
from caricli.models.detector.model import by_pixels, face_cells
from caricli.models.detector.networks import FaceGrid, HeatMaps
from caricli.structures.detection import FaceFrame, MarkedPicture, turn_axes
from tests.drawn_pictures import mean_shape

CONFIG = DetectorConfig()


@pytest.fixture(scope="module")
def faces(head_template):
    """Landmarks of two faces in a window of 128 pixels: one of them turned, one small."""
    shape = mean_shape(head_template)
    return np.stack([70 * shape @ turn_axes(0.4) + [75, 60], 20 * shape + [20, 100]])


def window(faces, visible=1.0):
    """A MarkedPicture of which nothing is asked but the faces; visible: share of their landmarks."""
    seen = np.broadcast_to(np.arange(81) < visible * 81, faces.shape[:2])
    return MarkedPicture(np.zeros((128, 128, 3), np.float32), np.zeros((128, 128), np.uint8), faces, seen)


def grid_of(targets, confidence=8.0):
    """The grid that says what is asked for."""
    heat, values = torch.from_numpy(targets.heat), torch.from_numpy(targets.values)
    score = torch.where(heat == 1, confidence, -confidence)
    return FaceGrid(score, values[:, :2], values[:, 2], values[:, 3:])


def test_a_grid_that_says_what_is_asked_for_gives_the_faces(faces):
    targets = FaceTargets.of([window(faces)], 128)
    grid = grid_of(targets)
    cells = face_cells(torch.cat([grid.score[:, None], grid.shift, grid.size[:, None], grid.turn], 1)[0].numpy())
    best = np.flatnonzero(cells.score > 0.5)
    frames = sorted((FaceFrame.of(face) for face in faces), key=lambda frame: frame.centre[1])
    assert len(best) == 2
    for cell, frame in zip(best, frames, strict=True):
        np.testing.assert_allclose(cells.centre[cell], frame.centre, atol=1e-4)
        assert cells.side[cell] == pytest.approx(frame.side, rel=1e-5)
        assert cells.roll[cell] == pytest.approx(frame.roll, abs=1e-5)


def test_such_a_grid_costs_nothing_and_another_does(faces):
    targets = FaceTargets.of([window(faces), window(faces[:0])], 128)
    best = float(face_loss(grid_of(targets), targets))
    assert best < 1e-3
    blind = FaceGrid(*(torch.zeros_like(part) for part in vars(grid_of(targets)).values()))
    assert float(face_loss(blind, targets)) > 100 * max(best, 1e-4)


def test_alarms_cost_less_near_a_face_and_nothing_where_one_may_be():
    """Of four cells a face, one beside it, one of which nothing is asked, and one far away; all say one half."""
    heat = torch.tensor([[[1.0, 0.5], [0.2, 0.0]]])
    counts = torch.tensor([[[True, True], [False, True]]])
    values, near = torch.zeros(1, 5, 2, 2), torch.zeros(1, 2, 2, dtype=torch.bool)
    grid = FaceGrid(torch.zeros(1, 2, 2), values[:, :2], values[:, 2], values[:, 3:])
    half = 0.25 * np.log(2)
    loss = float(face_loss(grid, FaceTargets(heat, counts, values, near)))
    assert loss == pytest.approx(half * (1 + 0.5**4 + 1))


def test_faces_of_other_sizes_are_neither_asked_for_nor_forbidden(head_template):
    face = 8 * mean_shape(head_template) + [64, 64]
    targets = FaceTargets.of([window(face[None])], 128)
    assert not targets.near.any() and not (targets.heat == 1).any() and not targets.counts.all()
    assert targets.counts[0, 0, 0]


def test_a_face_that_is_hidden_may_be_found_or_not(faces):
    targets = FaceTargets.of([window(faces, visible=0.1)], 128)
    assert not targets.near.any() and not targets.counts.all()


def heat_maps(places, deviation, covariance):
    """HeatMaps with blobs at places (1, 81, 2) in cells."""
    cells = torch.arange(32.0)
    squares = [(cells - places[..., axis, None]) ** 2 for axis in (0, 1)]
    logits = -(squares[1][..., :, None] + squares[0][..., None, :]) / (2 * deviation**2)
    spreads = torch.eye(2).expand(1, 81, 2, 2) * covariance
    return HeatMaps(logits, places, torch.logsumexp(logits, (2, 3)), spreads, torch.full((1, 81), 8.0))


def test_true_places_cost_least(faces):
    truth = torch.from_numpy(faces[:1]).float()
    visible = torch.ones(1, 81, dtype=torch.bool)
    places = (truth + 0.5) / 4 - 0.5
    right, distance = landmark_loss(heat_maps(places, 1.1, 0.02), truth, visible, 128, CONFIG)
    assert float(distance) < 1e-6
    for moved in (places + torch.tensor([1.0, 0]), places - torch.tensor([0, 2.0])):
        wrong, apart = landmark_loss(heat_maps(moved, 1.1, 0.02), truth, visible, 128, CONFIG)
        assert float(wrong) > float(right) + 0.1 and float(apart) > 0.03


def test_landmarks_beyond_the_window_or_hidden_have_no_error(faces):
    truth = torch.from_numpy(faces[:1]).float()
    truth[0, 0, 1] = 140.0
    visible = torch.ones(1, 81, dtype=torch.bool)
    visible[0, 1] = False
    places = (truth + 0.5) / 4 - 0.5
    far = places.clone()
    far[0, 0] -= 3
    right, wrong = (landmark_loss(heat_maps(where, 1.1, 0.02), truth, visible, 128, CONFIG) for where in (places, far))
    assert torch.equal(right[0], wrong[0])
    far[0, 1] -= 3
    hidden = landmark_loss(heat_maps(far, 1.1, 0.02), truth, visible, 128, CONFIG)
    assert hidden[0] > right[0] and float(hidden[1]) < 1e-6


def test_doubt_is_that_of_student_with_the_covariance():
    covariance = np.array([[4.0, 1.5], [1.5, 1.0]])
    errors = np.array([[0.0, 0], [2, 0], [0, 2], [2, 1], [-2, 1]])
    maps = heat_maps(torch.zeros(1, 81, 2), 1.1, 1.0)
    maps = replace(maps, covariance=torch.from_numpy(covariance).float().expand(1, 81, 2, 2))
    places = torch.zeros(1, 81, 2)
    places[0, : len(errors)] = torch.from_numpy(errors)
    cost = _doubt(maps, places)[0, : len(errors)].numpy()
    density = multivariate_t.logpdf(errors, shape=covariance, df=TAILS)
    np.testing.assert_allclose(cost - cost[0], density[0] - density, atol=1e-5)


def test_honest_doubt_costs_less_than_any_other(faces):
    truth = torch.from_numpy(faces[:1]).float()
    visible = torch.ones(1, 81, dtype=torch.bool)
    noise = torch.randn((1, 81, 2), generator=torch.Generator().manual_seed(0))
    places = (truth + 0.5) / 4 - 0.5 + noise
    costs = {
        spread: float(landmark_loss(heat_maps(places, 1.1, spread), truth, visible, 128, CONFIG)[0])
        for spread in (0.1, 0.7, 10.0)
    }
    assert min(costs, key=costs.get) == 0.7


def test_a_small_region_that_is_missed_costs_as_much_as_a_large_one():
    """Of two regions of 4 and of 1020 cells, shown as one another."""
    regions = np.zeros((1, 64, 64), np.uint8)
    regions[:, :4, :4] = 12
    truth = torch.from_numpy(regions[0, ::2, ::2].reshape(16, 2, 16, 2).transpose(0, 2, 1, 3).reshape(-1).astype(int))

    def apart(told):
        return float(_apart(torch.log_softmax(20 * torch.eye(16)[told], -1), truth))

    assert apart(truth) < 1e-3
    assert apart(torch.zeros_like(truth)) == pytest.approx(0.5, abs=0.01)
    assert apart(torch.full_like(truth, 12)) == pytest.approx(1, abs=0.01)
    beyond = truth.where(truth == 0, 255)
    assert float(_apart(torch.log_softmax(20 * torch.eye(16)[torch.zeros_like(truth)], -1), beyond)) < 1e-3


def test_regions_are_asked_for_where_they_are_read():
    regions = np.random.default_rng(0).integers(0, 16, (2, 32, 32)).astype(np.uint8)
    regions[:, :4] = 255
    logits = torch.zeros(2, 16, 16, 4, 16, requires_grad=True)
    region_loss(logits, torch.from_numpy(regions)).backward()
    likeliest = by_pixels(-logits.grad.numpy()).argmax(-1)
    told = regions < 16
    np.testing.assert_array_equal(likeliest[told], regions[told])
    assert not logits.grad.view(2, 16, 16, -1)[:, :2].any(), "nothing is asked for beyond the picture"
