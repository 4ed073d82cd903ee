from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.train.deformable.surface import Surface
from caricli.models.ablation.config import AblationConfig
from caricli.models.ablation.networks import ArraySize, ConditionedSiren, VertexArray
from caricli.models.deformable.config import NetworkSize
from caricli.models.deformable.model import UnitBox

SIZE = NetworkSize(latent=6, width=16, layers=4, hidden=8)


@pytest.fixture(scope="module")
def surface(ball):
    return Surface(UnitBox(ball[0]), ball[1])


@pytest.fixture(scope="module")
def latents():
    return torch.from_numpy(np.random.default_rng(0).normal(0, 0.01, (5, 6)).astype(np.float32))


def conditioned(size=SIZE, **options):
    return ConditionedSiren(size, 0.01, torch.Generator().manual_seed(0), **options)


def array(count, **options):
    return VertexArray(ArraySize(SIZE.latent, 10, count), 0.01, torch.Generator().manual_seed(0), **options)


def test_conditioning_is_concatenation_to_the_first_and_the_middle_layer(surface, latents):
    network = conditioned()
    points = surface.draw(40, 0.5, np.random.default_rng(1))
    weights, biases = list(network.tensors[::2]), list(network.tensors[1::2])
    repeated = (latents / 0.01)[:, None].expand(-1, 40, -1)
    x = points.positions.expand(5, -1, -1)
    for k, (weight, bias) in enumerate(zip(weights, biases, strict=True)):
        if k in (0, 2):
            weight = torch.cat([weight, network.latent_weights[k // 2]], dim=1)
            x = torch.cat([x, repeated], dim=-1)
        x = x @ weight.T + bias
        x = torch.sin(SIZE.frequency * x) if k < 4 else x
    torch.testing.assert_close(network(latents, points), x, atol=1e-5, rtol=1e-4)


@pytest.mark.parametrize("layers", [1, 2, 3, 5])
def test_any_number_of_layers_can_be_conditioned(surface, latents, layers):
    network = conditioned(replace(SIZE, layers=layers))
    points = surface.at_vertices(np.arange(7))
    moved = network(latents, points)
    assert moved.shape == (5, 7, 3)
    assert (moved[0] - moved[1]).abs().max() > 1e-4


def test_arrays_interpolate_what_they_put_out_at_the_vertices(surface, latents):
    network = array(300)
    at_vertices = network(latents, surface.at_vertices(np.arange(300)))
    points = surface.draw(50, 0.2, np.random.default_rng(2))
    torch.testing.assert_close(network(latents, points), points.values(at_vertices))


def test_arrays_of_positions_and_displacements_differ_by_the_template(surface, latents):
    points = surface.draw(50, 0.2, np.random.default_rng(2))
    positions, displacements = array(300, positions=True), array(300)
    torch.testing.assert_close(positions(latents, points) + points.positions, displacements(latents, points))


def test_training_starts_near_the_template(surface, latents):
    points = surface.at_vertices(np.arange(300))
    size = NetworkSize()
    drawn = torch.from_numpy(np.random.default_rng(0).normal(0, 0.01, (8, 128)).astype(np.float32))
    generator = torch.Generator().manual_seed(0)
    for network in (
        ConditionedSiren(size, 0.01, generator),
        VertexArray(ArraySize(size.latent, 400, 300), 0.01, generator),
    ):
        moved = network(drawn, points)
        assert moved.norm(dim=-1).mean() < 0.1
        # Different from the start, so that there is something to learn from.
        assert (moved[0] - moved[1]).norm(dim=-1).mean() > 1e-3


def test_parameters_are_the_papers():
    network = VertexArray(ArraySize(NetworkSize().latent, 400, 11_551), 0.01, torch.Generator())
    count = sum(p.numel() for p in network.parameters())
    assert count == 128 * 400 + 400 + 401 * 3 * 11_551  # 13.9 M


def test_weights_come_from_the_generator():
    for make in (conditioned, lambda: array(300)):
        for a, b in zip(make().parameters(), make().parameters(), strict=True):
            assert torch.equal(a, b)


@pytest.mark.parametrize("name", ["tiny", "default", "paper"])
def test_the_bundled_settings_can_be_read(name):
    config = read_config(config_path(f"ablation/{name}.yaml"), AblationConfig)
    assert config.start == "random" and config.vertex_share == 0.5 and not config.patience


@pytest.mark.parametrize("setting", ["meshes=-1", "array_hidden=0", "code_steps=0", "epochs=0", "start=zero"])
def test_impossible_settings_are_refused(setting):
    with pytest.raises(InputError, match=setting.split("=")[0]):
        read_config(None, AblationConfig, [setting])
