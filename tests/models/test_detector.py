import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.models.detector.calibration import Calibration
from caricli.models.detector.config import DetectorConfig, DetectorSize
from caricli.models.detector.jaw_places import JawPlaces
from caricli.models.detector.model import (
    JAW_BIAS,
    JAW_USUAL,
    JAW_WEIGHT,
    detector_from_checkpoint,
    detector_to_checkpoint,
    face_cells,
)
from caricli.models.detector.networks import DetectorNetwork, _moments, _spread, detector_of, network_of
from caricli.models.detector.usual_shapes import UsualShapes
from caricli.structures.parsing import Region


@pytest.fixture(scope="module")
def detector():
    """One with random weights, also those that a training begins with as zeros."""
    generator = torch.Generator().manual_seed(0)
    network = DetectorNetwork(DetectorSize(8, 16, 1), 81, len(Region), generator)
    for parameter in network.parameters():
        if not parameter.any():
            torch.nn.init.uniform_(parameter, 0, 0.5, generator)
    numbers = np.random.default_rng(0)
    usual = UsualShapes.of(numbers.normal(size=(40, 136)), 3)
    jaw = JawPlaces(numbers.normal(size=(14, 136)), np.linspace(0, 1, 14), usual)
    detector = detector_of(network, 64, {"seed": 0})
    detector.calibration = Calibration(1.5, jaw, (0.25, -0.1))
    return detector


def test_blobs_have_their_mean_and_their_spread():
    mean = torch.tensor([[[12.0, 20.5]]])
    covariance = torch.tensor([[4.0, 1.5], [1.5, 3.0]])
    places = torch.stack(torch.meshgrid(torch.arange(32.0), torch.arange(32.0), indexing="xy"), -1) - mean[0, 0]
    heights = torch.exp(-0.5 * (places @ torch.linalg.inv(covariance) * places).sum(-1))[None, None]
    moments = _moments(heights)
    found = torch.stack([moments[..., 0, 1], moments[..., 1, 0]], -1) / moments[..., :1, 0]
    torch.testing.assert_close(found, mean, atol=1e-3, rtol=0)
    torch.testing.assert_close(_spread(moments, found)[0, 0], covariance, atol=1e-2, rtol=0)


def test_windows_of_any_size_are_searched_and_those_of_its_own_read(detector):
    generator = np.random.default_rng(0)
    window = generator.integers(0, 256, (96, 160, 3), np.uint8)
    regions = detector.parse(window)
    cells, same = detector.search(window)
    assert len(cells.score) == 6 * 10 and regions.shape == (48, 80, 16)
    np.testing.assert_array_equal(same, regions)
    np.testing.assert_allclose(regions.sum(-1), 1, atol=1e-5)
    reading = detector.read(generator.integers(0, 256, (2, 64, 64, 3), np.uint8))
    assert reading.points.shape == (2, 81, 2) and reading.regions.shape == (2, 32, 32, 16)
    assert ((reading.points > -2) & (reading.points < 66)).all()
    assert (np.linalg.eigvalsh(reading.covariance) > 0).all()


def test_it_sees_what_the_network_sees_that_was_trained(detector):
    """Norms with statistics of their own, as a training leaves them."""
    generator = torch.Generator().manual_seed(1)
    network = network_of(detector)
    for module in network.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            torch.nn.init.uniform_(module.running_mean, -1, 1, generator)
            torch.nn.init.uniform_(module.running_var, 0.5, 2, generator)
            torch.nn.init.uniform_(module.weight, 0, 2, generator)
    trained = detector_of(network, 64)
    network = network_of(trained)
    windows = np.random.default_rng(0).integers(0, 256, (2, 64, 96, 3), np.uint8)
    features, levels = network.coarse(torch.from_numpy(windows / np.float32(255)).permute(0, 3, 1, 2))
    grid = network.faces(features)
    fine = network.fine(features, levels)
    chances = torch.softmax(network.parse(fine, levels), -1)
    maps = network.read(fine)
    for number, window in enumerate(windows):
        cells, regions = trained.search(window)
        np.testing.assert_allclose(cells.score, torch.sigmoid(grid.score[number]).ravel(), atol=1e-5)
        np.testing.assert_allclose(cells.roll, torch.atan2(*grid.turn[number].flip(0)).ravel(), atol=1e-3)
        np.testing.assert_allclose(regions[::2, ::2], chances[number, :, :, 0], atol=1e-5)
        np.testing.assert_allclose(regions[::2, 1::2], chances[number, :, :, 1], atol=1e-5)
    reading = trained.read(windows)
    np.testing.assert_allclose(reading.points, (maps.mean + 0.5) * 4 - 0.5, atol=1e-3)
    np.testing.assert_allclose(reading.covariance, maps.covariance * 16, rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(reading.visible, torch.sigmoid(maps.visible), atol=1e-5)


def test_cells_tell_where_faces_are_in_the_pixels_of_the_window():
    """Cells of 16 pixels: without a shift a face is in the middle of its cell."""
    grid = np.zeros((6, 2, 3))
    grid[4] = 1
    grid[:, 1, 2] = [2, 1, -0.5, 1, 0, 3]
    cells = face_cells(grid)
    np.testing.assert_array_equal(cells.cell, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]])
    np.testing.assert_allclose(cells.centre[:5], [[7.5, 7.5], [23.5, 7.5], [39.5, 7.5], [7.5, 23.5], [23.5, 23.5]])
    np.testing.assert_allclose(cells.centre[5], [39.5 + 16, 23.5 - 8])
    assert cells.side[5] == pytest.approx(2 * cells.side[0])
    np.testing.assert_allclose(cells.roll, [0, 0, 0, 0, 0, np.pi / 2])
    np.testing.assert_allclose(cells.score, [0.5] * 5 + [1 / (1 + np.exp(-2))])
    grid[3] = 1e6
    assert np.isfinite(face_cells(grid).side).all()


def test_doubts_are_multiplied_by_the_trust(detector):
    windows = np.random.default_rng(2).integers(0, 256, (1, 64, 64, 3), np.uint8)
    other = detector_of(network_of(detector), 64)
    reads = []
    for trust in (1.5, 3.0):
        other.calibration = Calibration(trust)
        reads.append(other.read(windows))
    first, second = reads
    np.testing.assert_allclose(second.covariance, 4 * first.covariance, rtol=1e-5)
    np.testing.assert_array_equal(second.points, first.points)


def test_a_checkpoint_rebuilds_it(detector):
    tensors, about = detector_to_checkpoint(detector)
    again = detector_from_checkpoint({name: value.astype(np.float32) for name, value in tensors.items()}, about, "it")
    assert (again.size, again.recipe) == (64, {"seed": 0})
    assert (again.calibration.trust, again.calibration.shift) == (1.5, (0.25, -0.1))
    assert {value.dtype for value in tensors.values()} == {np.dtype(np.float16), np.dtype(np.float32)}
    window = np.random.default_rng(1).integers(0, 256, (1, 64, 64, 3), np.uint8)
    np.testing.assert_allclose(again.read(window).points, detector.read(window).points, atol=0.5)
    own, before = again.calibration.jaw, detector.calibration.jaw
    np.testing.assert_allclose(own.weight, before.weight, rtol=1e-6)
    np.testing.assert_allclose(own.bias, before.bias, rtol=1e-6)
    for name in ("middle", "axes", "spreads"):
        np.testing.assert_allclose(getattr(own.usual, name), getattr(before.usual, name), rtol=1e-6)


def test_a_detector_of_before_knows_no_usual_faces(detector):
    tensors, about = detector_to_checkpoint(detector)
    before = {name: value for name, value in tensors.items() if name not in JAW_USUAL}
    jaw = detector_from_checkpoint(before, about, "it").calibration.jaw
    assert jaw.usual is None and jaw.weight.any()


def test_regions_of_a_detector_of_before_are_where_its_pixels_are(detector):
    tensors, about = detector_to_checkpoint(detector)
    del about["shift"]
    assert detector_from_checkpoint(tensors, about, "it").calibration.shift == (0.0, 0.0)


def test_a_detector_of_before_marks_jaws_at_equal_distances(detector):
    tensors, about = detector_to_checkpoint(detector)
    before = {name: value for name, value in tensors.items() if not name.startswith("jaw.")}
    jaw = detector_from_checkpoint(before, about, "it").calibration.jaw
    assert not jaw.weight.any() and np.array_equal(jaw.bias, JawPlaces.even().bias)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, a: a.update(schema="other"), "expected a detector of schema"),
        (lambda t, a: a.update(size=7), "expected a size from 64 to 512, found '7'"),
        (lambda t, a: a.update(size=100), "expected a size that is a multiple of 32, found 100"),
        (lambda t, a: a.update(trust=0.0), "expected a trust from"),
        (lambda t, a: a.update(trust=101.0), "expected a trust from"),
        (lambda t, a: a.update(shift=[0.1]), "expected a shift of two numbers up to 0.5"),
        (lambda t, a: a.update(shift=[0.1, -0.6]), "expected a shift of two numbers up to 0.5"),
        (lambda t, a: a.update(network={"stem": 8}), "expected a network of stem, width, depth"),
        (lambda t, a: a["network"].update(width=10**9), "width must be from 8 to 512"),
        (lambda t, a: a.update(regions=["skin"]), "regions that caricli knows"),
        (lambda t, a: t.pop("about"), "expected the weights of such a network, found others \\(about\\)"),
        (lambda t, a: t.update(about=t["about"][:1]), "about: expected \\(81, 16, 3\\), found"),
        (lambda t, a: t.update(about=t["about"] * np.nan), "about: "),
        (lambda t, a: t.pop(JAW_BIAS), "expected jaw.weight, jaw.bias, found 1 of them"),
        (lambda t, a: t.pop(JAW_USUAL[1]), "expected jaw.middle, jaw.axes, jaw.spreads, found 2 of them"),
        (lambda t, a: t.update({JAW_USUAL[1]: np.ones((2, 136))}), "usual shapes that fit each other"),
        (lambda t, a: t.update({JAW_USUAL[2]: np.zeros(4)}), "spreads of usual shapes above zero"),
        (lambda t, a: t.update({JAW_USUAL[0]: t[JAW_USUAL[0]] * np.nan}), "usual shapes' middle: "),
        (lambda t, a: t.update({JAW_BIAS: np.ones(13)}), "jaw's bias: expected \\(14,\\), found \\(13,\\)"),
        (lambda t, a: t.update({JAW_WEIGHT: t[JAW_WEIGHT] * np.inf}), "jaw's weight: "),
    ],
)
def test_what_is_no_detector_is_refused(detector, change, message):
    tensors, about = detector_to_checkpoint(detector)
    about["network"] = dict(about["network"])
    change(tensors, about)
    with pytest.raises(InputError, match=message):
        detector_from_checkpoint(tensors, about, "it")


@pytest.mark.parametrize("setting", [{"size": 100}, {"precision": "float16"}, {"crops": 0.0}, {"decay": 1.0}])
def test_impossible_settings_are_refused(setting):
    with pytest.raises(ValueError, match=next(iter(setting))):
        DetectorConfig(**setting)


def test_the_default_is_small_enough_to_come_along():
    network = DetectorNetwork(DetectorConfig().network(), 81, len(Region), torch.Generator())
    assert 2 * sum(value.numel() for value in network.parameters()) < 6e6
