"""What textures of one expression, made of another, are judged by (expressions paper, section 3.3.2)."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Self

import torch
from torch.nn import functional

from caricli.models.texture.config import TextureConfig
from caricli.models.texture.networks import Change, TextureCritic, TextureNetwork

_FLAT = 1e-12
"""Added to squared gradients, so that a root has a slope at nothing."""


@dataclass(frozen=True, eq=False)
class TextureBatch:
    """Textures of B people with one expression, and what they are to show.

    source, target: (B, 3, S, S) sRGB from 0 to 1; without pairs the target is of somebody else. forth, back: (B, 23, S,
    S) maps from source to target, and back. source_code, target_code: (B, 52) ARKit weights. moved: (B, 1, S, S) true
    attention. weight: (B, 1, S, S) how much a texel counts; its mean is about one. seen: (B, 1, S, S) bool, what
    both pictures showed. people: (B,) their numbers. paired: whether the target is the same person in the same look.
    """

    source: torch.Tensor
    target: torch.Tensor
    forth: torch.Tensor
    back: torch.Tensor
    source_code: torch.Tensor
    target_code: torch.Tensor
    moved: torch.Tensor
    weight: torch.Tensor
    seen: torch.Tensor
    people: torch.Tensor
    paired: bool

    def rows(self, rows: slice | torch.Tensor) -> Self:
        """Some of the people."""
        parts = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(self, **{name: part[rows] for name, part in parts.items() if name != "paired"})

    def change(self, network: TextureNetwork) -> Change:
        """From source to target."""
        return network(self.source, self.forth, torch.cat([self.source_code, self.target_code], 1))

    def change_back(self, network: TextureNetwork, pictures: torch.Tensor) -> Change:
        """From pictures (B, 3, S, S) of the target's expression to the source's."""
        return network(pictures, self.back, torch.cat([self.target_code, self.source_code], 1))


def attention_loss(change: Change, batch: TextureBatch) -> torch.Tensor:
    """Mean difference of attention from where the surface moves (equation 13)."""
    return (change.attention - batch.moved).abs().mean()


def colour_loss(pictures: torch.Tensor, expected: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """Mean difference of textures (equations 14 and 15), each texel by its weight."""
    return ((pictures - expected).abs() * weight).mean()


def cycle_loss(network: TextureNetwork, fake: torch.Tensor, batch: TextureBatch) -> torch.Tensor:
    """How far a texture comes back to itself (equation 15). fake: what became of it."""
    return colour_loss(batch.change_back(network, fake).paint(fake), batch.source, batch.weight)


def gradient_penalty(
    critic: Callable[[torch.Tensor], torch.Tensor], real: torch.Tensor, fake: torch.Tensor, shares: torch.Tensor
) -> torch.Tensor:
    """Mean of (|slope| - 1)² of the score between real and fake pictures (equation 16; Gulrajani et al. 2017).

    critic: pictures (B, 3, S, S) to scores (B,). shares: (B,) how far from fake to real it is measured.
    """
    between = torch.lerp(fake, real, shares[:, None, None, None]).detach().requires_grad_()
    (slope,) = torch.autograd.grad(critic(between).sum(), between, create_graph=True)
    lengths = (slope.flatten(1).square().sum(1) + _FLAT).sqrt()
    return (lengths - 1).square().mean()


def patch_score(scores: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """(B,) mean of patches' scores (B, h, w), each by the weight (B, 1, S, S) of its texels."""
    counts = functional.avg_pool2d(weight, weight.shape[-1] // scores.shape[-1])[:, 0]
    return (scores * counts).mean((1, 2))


def critic_loss(
    critic: TextureCritic, batch: TextureBatch, fake: torch.Tensor, shares: torch.Tensor, config: TextureConfig
) -> torch.Tensor:
    """What the critic minimises: equation 16, and the second term of equation 17.

    fake: (B, 3, S, S). shares: of ``gradient_penalty``.
    """
    real_scores, codes = critic(batch.source)
    fake_scores = critic(fake.detach())[0]
    apart = patch_score(fake_scores, batch.weight).mean() - patch_score(real_scores, batch.weight).mean()
    penalty = gradient_penalty(
        lambda pictures: patch_score(critic(pictures)[0], batch.weight), batch.source, fake.detach(), shares
    )
    expression = (codes - batch.source_code).square().mean()
    judged = config.adversarial_weight * (apart + config.penalty * penalty)
    return judged + config.expression_weight * expression


def fooling_loss(critic: TextureCritic, batch: TextureBatch, fake: torch.Tensor, config: TextureConfig) -> torch.Tensor:
    """What the generator minimises of equations 16 and 17. fake: (B, 3, S, S)."""
    scores, codes = critic(fake)
    expression = (codes - batch.target_code).square().mean()
    believed = patch_score(scores, batch.weight).mean()
    return config.expression_weight * expression - config.adversarial_weight * believed
