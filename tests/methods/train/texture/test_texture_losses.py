"""Losses of textures against slow independent versions."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from caricli.methods.train.texture.texture_losses import (
    TextureBatch,
    attention_loss,
    colour_loss,
    critic_loss,
    cycle_loss,
    fooling_loss,
    gradient_penalty,
    patch_score,
)
from caricli.models.texture.config import TextureConfig, TextureSize
from caricli.models.texture.networks import CODES, MAPS, Change, TextureCritic, TextureNetwork

SIDE = 32


def random(*shape, seed=0):
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed))


@pytest.fixture
def batch():
    source, target = (random(3, 3, SIDE, SIDE, seed=seed) for seed in (0, 1))
    forth, back = (random(3, MAPS, SIDE, SIDE, seed=seed) - 0.5 for seed in (2, 3))
    codes = random(2, 3, CODES // 2, seed=4)
    moved, weight = (random(3, 1, SIDE, SIDE, seed=seed) for seed in (6, 7))
    seen = torch.ones(3, 1, SIDE, SIDE, dtype=torch.bool)
    return TextureBatch(
        source, target, forth, back, codes[0], codes[1], moved, weight, seen, torch.arange(3), paired=True
    )  # fmt: skip


def network(**settings):
    """A network whose last layers are not nothing."""
    own = TextureNetwork(TextureSize(8, 4, **settings), torch.Generator().manual_seed(0)).eval()
    for branch in (own.colour, own.where):
        if branch is not None:
            torch.nn.init.normal_(branch.last.weight, std=0.05, generator=torch.Generator().manual_seed(1))
    return own


def test_the_gradient_penalty_is_that_of_differences():
    critic = TextureCritic(4, SIDE, torch.Generator().manual_seed(0)).double()
    real, fake = (random(2, 3, SIDE, SIDE, seed=seed).double() for seed in (1, 2))
    shares = torch.tensor([0.25, 0.7], dtype=torch.float64)

    def score(pictures):
        return critic(pictures)[0].mean((1, 2))

    lengths = []
    for row in range(2):
        between = (shares[row] * real[row] + (1 - shares[row]) * fake[row]).flatten()
        steps = 1e-5 * torch.eye(len(between), dtype=torch.float64)
        with torch.no_grad():
            sides = [score((between + way * steps).view(-1, 3, SIDE, SIDE)) for way in (1, -1)]
        lengths.append(float((sides[0] - sides[1]).div(2e-5).norm()))
    expected = np.mean([(length - 1) ** 2 for length in lengths])
    assert gradient_penalty(score, real, fake, shares).item() == pytest.approx(expected, rel=1e-4)


def test_the_gradient_penalty_of_a_plane_is_known_and_teaches():
    slope = torch.full((3, 4, 4), 0.5, requires_grad=True)
    pictures = [random(2, 3, 4, 4, seed=seed) for seed in (1, 2)]
    penalty = gradient_penalty(
        lambda values: (values * slope).sum((1, 2, 3)), pictures[0], pictures[1], torch.tensor([0.5, 0.1])
    )
    length = 0.5 * 48**0.5
    assert penalty.item() == pytest.approx((length - 1) ** 2, rel=1e-5)
    penalty.backward()
    np.testing.assert_allclose(slope.grad, 2 * (length - 1) * 0.5 / length, rtol=1e-4)


@pytest.mark.parametrize("relative", [True, False])
def test_attention_composes_as_equation_12(batch, relative):
    change = batch.change(network(relative=relative))
    painted = change.paint(batch.source)
    keep = 1 - change.attention  # the paper's A
    for row in range(3):
        for channel in range(3):
            old = batch.source[row, channel]
            colour = old + change.gain[row, channel] * old + change.offset[row, channel]
            expected = keep[row, 0] * old + (1 - keep[row, 0]) * colour
            torch.testing.assert_close(painted[row, channel], expected)
    assert 0 <= change.attention.min() and change.attention.max() <= 1
    if not relative:
        assert (change.gain == -1).all() and 0 < change.offset.min() and change.offset.max() < 1


def test_a_network_changes_nothing_at_first(batch):
    fresh = TextureNetwork(TextureSize(8, 4), torch.Generator().manual_seed(0)).eval()
    torch.testing.assert_close(batch.change(fresh).paint(batch.source), batch.source)


def test_attention_comes_from_expressions_alone(batch):
    own = network(relative=False)
    other = replace(batch, source=batch.target)
    torch.testing.assert_close(batch.change(own).attention, other.change(own).attention)
    assert not torch.equal(batch.change(own).offset, other.change(own).offset)


def test_a_cycle_goes_to_the_target_and_back(batch):
    own = network()
    fake = batch.change(own).paint(batch.source)
    total = 0.0
    for row in range(3):
        codes = torch.cat([batch.target_code[row], batch.source_code[row]])[None]
        change = own(fake[row : row + 1], batch.back[row : row + 1], codes)
        again = fake[row] + change.attention[0] * (change.gain[0] * fake[row] + change.offset[0])
        total += ((again - batch.source[row]).abs() * batch.weight[row]).mean().item() / 3
    assert cycle_loss(own, fake, batch).item() == pytest.approx(total, rel=1e-4)


def test_losses_are_means_of_differences(batch):
    change = Change(batch.weight, batch.source, batch.target)
    away = np.abs(batch.weight.numpy() - batch.moved.numpy()).mean()
    assert attention_loss(change, batch).item() == pytest.approx(away, rel=1e-5)
    weight = torch.zeros_like(batch.weight)
    weight[0, 0, 3, 4] = 1
    gap = (batch.source - batch.target)[0, :, 3, 4].abs().sum() / batch.source.numel()
    assert colour_loss(batch.source, batch.target, weight).item() == pytest.approx(gap.item(), rel=1e-5)


def test_a_painter_is_believed_and_a_critic_tells_apart(batch):
    """Of a critic whose score is how bright a picture is, and who reads the same of all weights."""
    batch = replace(batch, weight=torch.ones_like(batch.weight))
    config = TextureConfig(adversarial_weight=3.0, expression_weight=7.0, penalty=0.0)

    def seen(pictures):
        bright = pictures.mean((1, 2, 3))
        return bright[:, None, None], bright[:, None].expand(-1, CODES // 2)

    critic: Any = seen
    fake = batch.target / 2
    bright = {name: own.mean((1, 2, 3)) for name, own in (("fake", fake), ("real", batch.source))}
    away = {
        name: (bright[name][:, None] - codes).square().mean()
        for name, codes in (("fake", batch.target_code), ("real", batch.source_code))
    }
    fooled = fooling_loss(critic, batch, fake, config)
    assert fooled.item() == pytest.approx(float(7 * away["fake"] - 3 * bright["fake"].mean()), rel=1e-5)
    told = critic_loss(critic, batch, fake, torch.full((3,), 0.5), config)
    apart = bright["fake"].mean() - bright["real"].mean()
    assert told.item() == pytest.approx(float(7 * away["real"] + 3 * apart), rel=1e-5)


def test_patches_count_by_their_texels():
    scores = random(2, 4, 4)
    weight = torch.zeros(2, 1, SIDE, SIDE)
    weight[:, :, 8:16, 24:] = 2.0
    np.testing.assert_allclose(patch_score(scores, weight), scores[:, 1, 3] * 2 / 16, rtol=1e-6)


@pytest.mark.parametrize("settings", [{"maps": False}, {"codes": False}, {"attention": False}, {}])
def test_what_is_left_out_does_not_matter(batch, settings):
    own = network(**settings)
    painted = batch.change(own).paint(batch.source)
    blind = replace(batch, forth=torch.zeros_like(batch.forth))
    dumb = replace(batch, target_code=torch.zeros_like(batch.target_code))
    assert torch.equal(blind.change(own).paint(batch.source), painted) == (settings == {"maps": False})
    assert torch.equal(dumb.change(own).paint(batch.source), painted) == (settings == {"codes": False})
