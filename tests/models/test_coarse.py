import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.models.coarse.config import CoarseConfig, CoarseSize
from caricli.models.coarse.model import CoarseModel, coarse_from_checkpoint, coarse_to_checkpoint, window_marks
from caricli.models.coarse.networks import CoarseNetwork, WindowFeatures

SMALL = CoarseSize(8, (16, 24, 32, 40), (1, 0, 1, 1), False, 8, 32, glance=2)


def network(size=SMALL, seed=0):
    generator = torch.Generator().manual_seed(seed)
    own = CoarseNetwork(size, 81, 30, generator)
    for layer in (own.last, own.told_last) if size.landmarks else (own.last,):
        torch.nn.init.normal_(layer.weight, std=0.1, generator=generator)
    return own


@pytest.fixture(scope="module")
def model():
    return CoarseModel(network(), 64, "a" * 64, {"seed": 0})


@pytest.fixture(scope="module")
def windows():
    generator = np.random.default_rng(0)
    return generator.integers(0, 256, (2, 64, 64, 3), np.uint8), generator.uniform(0, 63, (2, 81, 2))


def test_a_checkpoint_rebuilds_it(model, windows):
    tensors, about = coarse_to_checkpoint(model)
    again = coarse_from_checkpoint(
        {name: value.astype(np.float32) for name, value in tensors.items()}, _json(about), "it"
    )
    assert (again.size, again.basis, again.recipe) == (64, "a" * 64, {"seed": 0})
    np.testing.assert_allclose(again.read(*windows), model.read(*windows), atol=0.05)


def test_unknown_landmarks_say_nothing_and_known_ones_do(model, windows):
    pixels, points = windows
    nowhere = model.read(pixels, np.full_like(points, np.nan))
    assert np.isfinite(nowhere).all() and np.abs(nowhere - model.read(pixels, points)).max() > 0.1
    blind = CoarseModel(network(CoarseSize(8, (16, 24, 32, 40), (1, 0, 1, 1), False, 8, 32, False, 0)), 64, "")
    np.testing.assert_array_equal(blind.read(pixels, points), blind.read(pixels, np.full_like(points, np.nan)))


def test_doubts_count_and_what_is_seen_is_looked_for_at_the_landmarks(model, windows):
    pixels, points = windows
    spreads = np.tile(4 * np.eye(2), (2, 81, 1, 1))
    sure = model.read(pixels, points, spreads)
    assert np.abs(sure - model.read(pixels, points, 9 * spreads)).max() > 0.01
    assert np.abs(sure - model.read(pixels, points)).max() > 0.01
    own = model.network
    size = pixels.shape[1]
    ramp = torch.linspace(0, 1, size)[None, None, None].expand(1, 3, size, size)
    marks = torch.from_numpy(window_marks(points[:1], None, size))
    near = own.encode(ramp, marks).near
    same = marks.clone()
    same[..., 1] = (same[..., 1] + 1) / 3  # a picture that changes from left to right alone
    inner = ((same > 0.2) & (same < 0.8) & (marks > 0.2) & (marks < 0.8))[0, :, :2].all(1)
    assert inner.sum() > 10
    torch.testing.assert_close(own.encode(ramp, same).near[0, inner], near[0, inner], atol=1e-4, rtol=1e-3)
    same[..., 0] = same[..., 0].flip(1)
    assert (own.encode(ramp, same).near - near)[0, inner].abs().max() > 0.01


def test_without_pictures_landmarks_alone_tell(model, windows):
    pixels, points = windows
    marks = torch.from_numpy(window_marks(points, None, 64))
    images = torch.from_numpy(pixels / np.float32(255)).permute(0, 3, 1, 2)
    features = model.network.encode(images, marks)
    both = model.network.tell(features, marks)
    first = WindowFeatures(features.whole[:1], features.near[:1])
    mixed = model.network.tell(first, marks)
    torch.testing.assert_close(mixed[0], both[0])
    none = WindowFeatures(features.whole[:0], features.near[:0])
    torch.testing.assert_close(mixed[1], model.network.tell(none, marks)[1])
    assert (mixed[1] - both[1]).abs().max() > 0.01


def test_what_comes_out_is_in_the_units_of_start_and_step(windows):
    own = network()
    before = CoarseModel(own, 64, "").read(*windows)
    own.start.fill_(3.0)
    own.step.fill_(2.0)
    np.testing.assert_allclose(CoarseModel(own, 64, "").read(*windows), 3 + 2 * before, rtol=1e-4, atol=1e-4)


def test_the_encoder_of_a_network_of_the_same_size_is_borrowed():
    own = network()
    assert own.borrow(network(seed=1).state_dict())
    for name, value in own.state_dict().items():
        source = network(seed=1 if name.startswith(("stem.", "down.")) else 0)
        assert torch.equal(source.state_dict()[name], value), name
    assert not own.borrow(network(CoarseSize(8, (16, 24, 32, 48), (1, 0, 1, 1), False, 8, 32, glance=2)).state_dict())


def test_the_published_depth_is_fifty_layers():
    from caricli.io.bundled import config_path
    from caricli.io.config import read_config

    size = read_config(config_path("coarse/paper.yaml"), CoarseConfig).network()
    assert size.bottleneck and 2 + 3 * sum(size.blocks) == 50


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, a: a.update(schema="other"), "expected a coarse network of schema"),
        (lambda t, a: a.update(size=7), "expected a size from 64 to 512"),
        (lambda t, a: a.update(size=100), "expected a size that is a multiple of 32, found 100"),
        (lambda t, a: a.update(outputs="3"), "expected a number of outputs"),
        (lambda t, a: a.update(basis=None), "expected the morphable model that it belongs to"),
        (lambda t, a: a.update(network={}), "expected a network of stem, widths"),
        (lambda t, a: a["network"].update(widths=16), "widths: expected a list"),
        (lambda t, a: a["network"].update(blocks=[1, 1]), "blocks must be 4 numbers"),
        (lambda t, a: a["network"].update(landmarks=1), "landmarks: expected true or false"),
        (lambda t, a: t.pop("usual"), "expected the weights of such a network, found others"),
        (lambda t, a: t.update(doubt=np.ones(3, np.float32)), "doubt: expected"),
    ],
)
def test_what_does_not_fit_is_refused(model, change, message):
    tensors, about = coarse_to_checkpoint(model)
    about = _json(about)
    coarse_from_checkpoint(tensors, about, "it")
    change(tensors, about)
    with pytest.raises(InputError, match=message):
        coarse_from_checkpoint(tensors, about, "it")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size": 100}, "multiple of 32"),
        ({"steps": 10, "rounds": 3}, "multiple of rounds"),
        ({"batch": 8, "painted": 4, "unmarked": 4}, "less than batch"),
        ({"precision": "float8"}, "precision"),
        ({"landmarks": False}, "glance must be 0"),
        ({"landmarks": False, "glance": 0}, "imagined must be 0"),
        ({"widths": (1, 2)}, "widths must be 4 numbers"),
    ],
)
def test_impossible_settings_are_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        CoarseConfig(**settings)


def _json(about):
    """What becomes of metadata in a file."""
    import json

    return json.loads(json.dumps(about))


def test_marks_are_shares_of_the_window_and_doubts_of_its_area():
    points = np.array([[[-0.5, 63.5], [31.5, np.nan]]])
    np.testing.assert_array_equal(window_marks(points, None, 64)[0, :, :2], [[0, 1], [0.5, np.nan]])
    assert np.isnan(window_marks(points, None, 64)[..., 2:]).all()
    spreads = np.tile([[4.0, 1.0], [1.0, 9.0]], (1, 2, 1, 1))
    np.testing.assert_allclose(64**2 * window_marks(points, spreads, 64)[0, :, 2:], [[4, 9, 1]] * 2)
    # The same face in a window twice as large, pixels counted from the middle of the first.
    twice = window_marks(2 * points + 0.5, 4 * spreads, 128)
    np.testing.assert_allclose(twice, window_marks(points, spreads, 64), rtol=1e-6)
