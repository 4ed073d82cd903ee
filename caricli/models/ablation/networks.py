"""The networks that the SIREN hypernetwork is compared with (deformable paper, section 4.2).

As the hypernetwork they begin with small outputs that hardly depend on the latent, and their latents are scaled so that
they can learn from them as fast; without that they are far behind for no reason of their own.
"""

from dataclasses import dataclass
from math import sqrt

import torch
from torch import nn

from caricli.models.deformable.config import NetworkSize
from caricli.models.deformable.networks import Affine, TemplatePoints, siren, siren_start

_SLOPE = 0.1
"""Of the leaky ReLU below zero."""


@dataclass(frozen=True)
class ArraySize:
    """latent: D. hidden: width of the hidden layer. vertices: V."""

    latent: int
    hidden: int
    vertices: int


class VertexArray(nn.Module):
    """All vertices at once: latent -> hidden -> 3 V with a leaky ReLU (supplement 3).

    Positions and displacements differ by a constant, so only in where training starts: the origin or the template.
    """

    def __init__(self, size: ArraySize, latent_std: float, generator: torch.Generator, positions: bool = False) -> None:
        """latent_std, generator: see ConditionedSiren. positions: put out positions instead of displacements."""
        super().__init__()
        self.first = Affine(size.latent, size.hidden, generator)
        self.last = Affine(size.hidden, 3 * size.vertices, generator, scale=0.01)
        self.latent_std = latent_std
        self.positions = positions

    def forward(self, latents: torch.Tensor, points: TemplatePoints) -> torch.Tensor:
        """Latents (B, D) and points to displacements (B, n, 3)."""
        hidden = nn.functional.leaky_relu(self.first(latents / self.latent_std), _SLOPE)
        fields = points.values(self.last(hidden).unflatten(-1, (-1, 3)))
        return fields - points.positions if self.positions else fields


class ConditionedSiren(nn.Module):
    """One SIREN for all shapes; the latent is concatenated to the inputs of its first and its middle layer.

    That is the same as a linear function of the latent added to those layers' biases, and so it is computed.
    """

    def __init__(
        self,
        size: NetworkSize,
        latent_std: float,
        generator: torch.Generator,
        precision: torch.dtype = torch.float32,
    ) -> None:
        """latent_std: latents are divided by it, so that they weigh as much as features do.

        generator: of the initial weights. precision: see ``siren``.
        """
        super().__init__()
        self.size = size
        self.latent_std = latent_std
        self.precision = precision
        self.middle = max(1, size.layers // 2)
        self.tensors = nn.ParameterList(siren_start(size, generator))
        # The features of the middle layer share its input with the latent: weights for the sum of both.
        self.tensors[2 * self.middle].data *= sqrt(size.width / (size.width + size.latent))
        self.latent_weights = nn.ParameterList()
        for inputs, outputs in zip((3, size.width), (self.tensors[1], self.tensors[2 * self.middle + 1]), strict=True):
            bound = sqrt(6 / (inputs + size.latent)) / size.frequency
            weight = torch.empty(len(outputs), size.latent).uniform_(-bound, bound, generator=generator)
            self.latent_weights.append(weight)

    def forward(self, latents: torch.Tensor, points: TemplatePoints) -> torch.Tensor:
        """Latents (B, D) and points to displacements (B, n, 3)."""
        tensors = list(self.tensors)
        for layer, weight in zip((0, self.middle), self.latent_weights, strict=True):
            tensors[2 * layer + 1] = tensors[2 * layer + 1] + latents / self.latent_std @ weight.mT
        return siren(points.positions, tensors, self.size.frequency, self.precision)
