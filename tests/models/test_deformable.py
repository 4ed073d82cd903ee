import numpy as np
import pytest
import scipy.sparse as sp
import torch

from caricli.errors import InputError, NumericsError
from caricli.models.checkpoint import model_from_checkpoint, model_to_checkpoint
from caricli.models.deformable.config import DeformableConfig, NetworkSize
from caricli.models.deformable.model import DeformableModel, UnitBox
from caricli.models.deformable.networks import HyperSiren, siren
from caricli.models.prior import Prior

SIZE = NetworkSize(latent=6, width=16, layers=3, hidden=12)


@pytest.fixture(scope="module")
def model(head):
    """A network of random weights, with a prior that moves faces by about a centimetre."""
    template = head.template()
    network = HyperSiren(SIZE, torch.Generator().manual_seed(0))
    for layer in network.last:
        layer.weight.data *= 10
    prior = Prior(np.full(6, 0.01), 0.01 * np.tril(np.random.default_rng(1).normal(size=(6, 6)), -1) + 0.03 * np.eye(6))
    return DeformableModel(template, network, head.open_mouth_template().vertices, prior)


def test_a_network_that_makes_one_shape_alone_encodes_none(model):
    network = HyperSiren(SIZE, torch.Generator().manual_seed(0))
    for parameter in network.parameters():
        torch.nn.init.zeros_(parameter)
    still = DeformableModel(model.template, network, model.template.vertices, model.prior)
    with pytest.raises(NumericsError, match="no two shapes"):
        still.encode(model.template.vertices)


def test_the_paper_network_has_the_parameters_that_the_paper_counts():
    network = HyperSiren(NetworkSize(), torch.Generator())
    assert sum(p.numel() for p in network.parameters()) == 13_949_955


def test_training_starts_near_the_template():
    latents = 0.01 * torch.randn(5, 128, generator=torch.Generator().manual_seed(1))
    points = torch.rand(100, 3, generator=torch.Generator().manual_seed(2)) * 2 - 1
    network = HyperSiren(NetworkSize(), torch.Generator().manual_seed(0))
    moved = network.displacements(latents, points)
    assert moved.shape == (5, 100, 3)
    assert moved.abs().mean() < 0.1
    # All faces begin as the same one.
    assert (moved - moved.mean(0)).abs().max() < 0.01


def test_the_siren_keeps_the_spread_of_its_signals_through_the_layers():
    points = torch.rand(2000, 3, generator=torch.Generator().manual_seed(2)) * 2 - 1
    network = HyperSiren(NetworkSize(layers=6), torch.Generator().manual_seed(0))
    weights = network.weights(torch.zeros(128))
    for depth in (2, 4, 6):
        # The last layer replaced by the identity shows the features of the layer before it.
        shown = siren(points, [*weights[: 2 * depth], torch.eye(128), torch.zeros(128)], 30.0)
        assert 0.5 < shown.std() < 0.8


def test_the_siren_is_the_formula_written_out():
    generator = torch.Generator().manual_seed(3)
    network = HyperSiren(SIZE, generator)
    points, latent = torch.rand(4, 3, generator=generator), torch.rand(6, generator=generator)
    weights = network.weights(latent)
    x = points
    for k in range(3):
        x = torch.sin(30 * (x @ weights[2 * k].T + weights[2 * k + 1]))
    expected = x @ weights[-2].T + weights[-1]
    assert torch.allclose(network.displacements(latent, points), expected, atol=1e-5)


def test_batches_of_latents_agree_with_one_by_one(model):
    latents = model.prior.sample(np.random.default_rng(0), 6).reshape(2, 3, -1)
    shapes = model.decode(latents)
    assert shapes.shape == (2, 3, *model.template.vertices.shape)
    assert np.abs(shapes[1, 2] - model.decode(latents[1, 2])).max() < 1e-6


def test_the_jacobian_is_that_of_automatic_differentiation(model):
    points = model.template.annotation.landmarks
    latent = model.prior.sample(np.random.default_rng(0), 1)[0]
    positions, jacobian = model.points_jacobian(latent, points)
    assert np.abs(positions - model.decode(latent)[points]).max() < 1e-6
    places = torch.from_numpy(model.box.normalise(model.box.points[points]).astype(np.float32))
    given = torch.tensor(latent, dtype=torch.float32)
    slow = torch.func.jacfwd(lambda z: model.network.displacements(z, places))(given)
    assert np.abs(jacobian - slow.numpy() / model.box.scale).max() < 1e-5 * np.abs(jacobian).max()


def test_encoding_finds_what_was_decoded(model):
    latents = model.prior.sample(np.random.default_rng(4), 3)
    shapes = model.decode(latents)
    found = model.encode(shapes)
    assert found.shape == latents.shape
    errors = np.linalg.norm(model.decode(found) - shapes, axis=-1).mean(-1)
    spread = np.linalg.norm(shapes - model.decode(model.prior.mean), axis=-1).mean(-1)
    assert (errors < 0.02 * spread).all()


def test_more_points_are_the_same_function(model):
    latent = model.prior.sample(np.random.default_rng(0), 1)[0]
    between = model.box.points[model.template.faces].mean(1)
    fine = model.decode_at(latent, np.concatenate([model.box.points, between]))
    assert np.abs(fine[: len(model.box.points)] - model.decode(latent)).max() < 1e-6


def test_it_survives_its_checkpoint(model):
    tensors, metadata = model_to_checkpoint(model, {"command": "test"})
    # Half precision comes back from a file in single precision.
    tensors = {k: v.astype(np.float32) if v.dtype == np.float16 else v for k, v in tensors.items()}
    again = model_from_checkpoint(tensors, metadata, "model")
    latent = model.prior.sample(np.random.default_rng(0), 1)[0]
    assert again.network.size == SIZE
    assert np.abs(again.decode(latent) - model.decode(latent)).max() < 1e-3
    first, second = (m.tensors() for m in (again, again))
    assert all(np.array_equal(first[name], second[name]) for name in first)


def test_a_unit_box_fills_the_cube():
    points = np.random.default_rng(0).normal(size=(50, 3)) * [1, 2, 3] + 5
    inside = UnitBox(points).normalise(points)
    assert np.abs(inside).max() == pytest.approx(1)
    assert np.ptp(inside, axis=0).max() == pytest.approx(2)


@pytest.mark.parametrize(
    "change",
    [
        {"latent": 0},
        {"batch": 0},
        {"points": 2},
        {"vertex_share": 1.5},
        {"learning_rate": 0.0},
        {"start": "zero"},
        {"precision": "int8"},
        {"epochs": 10**9},
    ],
)
def test_impossible_settings_are_refused(change):
    with pytest.raises(ValueError, match=next(iter(change))):
        DeformableConfig(**change)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("points", lambda t: 0 * t, "points of its template"),
        ("points", lambda t: 1e8 * t, "points of its template"),
        ("frequency", lambda t: 0 * t, "frequency must be from 0.001"),
        ("frequency", lambda t: -t, "frequency must be from 0.001"),
        ("network.last.0.weight", lambda t: t[:0], "width must be from 1"),
        ("network.last.0.weight", lambda t: np.tile(t, (80, 1)), "do not fit each other"),
        ("network.first.weight", lambda t: t[..., :0], "latent must be from 1"),
        ("prior_factor", lambda t: 1e-12 * t, "not a lower triangular factor"),
        ("prior_factor", lambda t: t.T, "not a lower triangular factor"),
    ],
)
def test_what_no_training_leaves_is_refused(model, name, change, words):
    tensors, metadata = model_to_checkpoint(model, {})
    tensors[f"model.{name}"] = change(tensors[f"model.{name}"])
    with pytest.raises(InputError, match=f"^m: not a valid model: .*{words}"):
        model_from_checkpoint(tensors, metadata, "m")


def test_many_points_are_decoded_piece_by_piece_as_at_once(model, monkeypatch):
    latents = model.prior.sample(np.random.default_rng(3), 2)
    with monkeypatch.context() as small:
        small.setattr("caricli.models.deformable.model._CHUNK", 1000)
        pieces = [model.decode(each) for each in (-latents, latents)]
    np.testing.assert_allclose(pieces, [model.decode(each) for each in (-latents, latents)], atol=1e-6)


def test_a_place_at_a_vertex_is_decoded_as_this_vertex(model):
    """Places lie on the template with its lips apart, as vertices do."""
    latent = model.prior.sample(np.random.default_rng(4), 1)[0]
    rows = sp.identity(len(model.template.vertices), format="csr")[[5, 4000, 70]]
    np.testing.assert_allclose(model.decode_on(latent, rows), model.decode(latent)[[5, 4000, 70]], atol=1e-6)
    lips = model.template.annotation.landmarks[60:68]
    apart = np.abs(model.box.points - model.template.vertices)[lips].max()
    assert apart > 1e-3
    at_lips = sp.identity(len(model.template.vertices), format="csr")[lips]
    np.testing.assert_allclose(model.decode_on(latent, at_lips), model.decode(latent)[lips], atol=1e-6)
