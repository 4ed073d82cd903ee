"""The SIREN and the hypernetwork that makes its weights from a latent (deformable paper, section 3)."""

from collections.abc import Iterator, Sequence
from math import prod, sqrt
from typing import Protocol

import torch
from torch import nn

from caricli.models.deformable.config import NetworkSize


class TemplatePoints(Protocol):
    """n points on the template's surface."""

    @property
    def positions(self) -> torch.Tensor:
        """(n, 3) in the network's coordinates, from -1 to 1."""

    def values(self, fields: torch.Tensor) -> torch.Tensor:
        """What is known at the vertices (..., V, 3), interpolated: (..., n, 3)."""


def siren(
    points: torch.Tensor, parameters: Sequence[torch.Tensor], frequency: float, precision: torch.dtype = torch.float32
) -> torch.Tensor:
    """Displacements of template points: sine layers, then a linear one (section 3.2).

    points: (..., N, 3) in [-1, 1]. parameters: weights (..., out, in) and biases (..., out) in turn. frequency: w0.
    precision: of the hidden layers; the first, whose phases are large, and the last stay as they are.
    Returns (..., N, 3).
    """
    first, *hidden = zip(parameters[:-2:2], parameters[1:-2:2], strict=True)
    x = torch.sin(_affine(points, frequency * first[0], frequency * first[1])).to(precision)
    for weight, bias in hidden:
        x = torch.sin(_affine(x, (frequency * weight).to(precision), (frequency * bias).to(precision)))
    return _affine(x.to(points.dtype), parameters[-2], parameters[-1])


class HyperSiren(nn.Module):
    """Latents to displacements: for every tensor of the SIREN one ReLU MLP, latent -> hidden -> hidden -> numel.

    The last layers start a hundred times smaller than Kaiming's initialisation and their biases hold a SIREN's, so that
    training starts near the template (supplement 2; SIREN: Sitzmann et al. 2020).
    """

    def __init__(self, size: NetworkSize, generator: torch.Generator, precision: torch.dtype = torch.float32) -> None:
        """generator: of the initial weights. precision: see ``siren``."""
        super().__init__()
        self.size = size
        self.precision = precision
        shapes = size.shapes()
        self.first = Affine(size.latent, size.hidden, generator, count=len(shapes))
        self.second = Affine(size.hidden, size.hidden, generator, count=len(shapes))
        self.last = nn.ModuleList(Affine(size.hidden, prod(shape), generator, scale=0.01) for shape in shapes)
        for layer, start in zip(self.last, siren_start(size, generator), strict=True):
            layer.bias.data = start.flatten()

    def weights(self, latents: torch.Tensor) -> list[torch.Tensor]:
        """Latents (..., D) to the SIREN's weights and biases with the same leading dimensions."""
        flat = latents.reshape(1, -1, latents.shape[-1])
        hidden = torch.relu(self.second(torch.relu(self.first(flat))))
        shapes = self.size.shapes()
        return [layer(hidden[k]).reshape(*latents.shape[:-1], *shapes[k]) for k, layer in enumerate(self.last)]

    def forward(self, latents: torch.Tensor, points: TemplatePoints) -> torch.Tensor:
        """Latents (..., D) and points on the template to displacements (..., n, 3)."""
        return self.displacements(latents, points.positions)

    def displacements(self, latents: torch.Tensor, positions: torch.Tensor) -> torch.Tensor:
        """Latents (..., D) and positions (..., N, 3) in [-1, 1] to displacements (..., N, 3)."""
        return siren(positions, self.weights(latents), self.size.frequency, self.precision)

    @torch.no_grad()
    def displacements_jacobian(
        self, latent: torch.Tensor, positions: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Displacements (N, 3) of positions (N, 3), and their derivatives (D, N, 3) by the latent (D,)."""
        frequency = self.size.frequency
        weights = self.weights(latent)
        derivatives = self._weights_derivatives(latent)
        x = positions
        dx = torch.zeros(len(latent), *positions.shape)
        for k in range(0, len(weights) - 2, 2):
            value, dvalue = _affine_with_derivative(x, dx, weights[k : k + 2], derivatives[k : k + 2])
            x = torch.sin(frequency * value)
            dx = frequency * torch.cos(frequency * value) * dvalue
        return _affine_with_derivative(x, dx, weights[-2:], derivatives[-2:])

    def _weights_derivatives(self, latent: torch.Tensor) -> list[torch.Tensor]:
        """Derivatives (D, *shape) of the SIREN's weights and biases."""
        first = self.first(latent[None])
        dfirst = (first > 0).mT * self.first.weight
        second = self.second(torch.relu(first))
        dsecond = (second > 0).mT * (self.second.weight @ dfirst)
        shapes = self.size.shapes()
        return [(layer.weight @ dsecond[k]).mT.reshape(-1, *shapes[k]) for k, layer in enumerate(self.last)]


class Affine(nn.Module):
    """An affine layer, initialised after Kaiming; with count, that many side by side on inputs (count or 1, B, in)."""

    def __init__(
        self, inputs: int, outputs: int, generator: torch.Generator, count: int | None = None, scale: float = 1.0
    ) -> None:
        """generator: of the weights. scale: of their deviation."""
        super().__init__()
        leading = () if count is None else (count,)
        weight = torch.empty(*leading, outputs, inputs).normal_(0, scale * sqrt(2 / inputs), generator=generator)
        self.weight = nn.Parameter(weight)
        self.bias = nn.Parameter(torch.zeros(*leading, outputs))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(..., in) to (..., out)."""
        return _affine(x, self.weight, self.bias)


def siren_start(size: NetworkSize, generator: torch.Generator) -> Iterator[torch.Tensor]:
    """The initial weights and biases of a SIREN in turn (Sitzmann et al. 2020, section 3.2)."""
    for k, shape in enumerate(size.shapes()):
        is_bias = k % 2 == 1
        inputs = size.shapes()[k - is_bias][1]
        if k == 0:
            bound = 1 / inputs
        elif is_bias:
            bound = 1 / sqrt(inputs)
        else:
            bound = sqrt(6 / inputs) / size.frequency
        yield torch.empty(shape).uniform_(-bound, bound, generator=generator)


def _affine(x: torch.Tensor, weight: torch.Tensor, bias: torch.Tensor) -> torch.Tensor:
    return x @ weight.mT + bias.unsqueeze(-2)


def _affine_with_derivative(
    x: torch.Tensor, dx: torch.Tensor, layer: Sequence[torch.Tensor], dlayer: Sequence[torch.Tensor]
) -> tuple[torch.Tensor, torch.Tensor]:
    weight, bias = layer
    dweight, dbias = dlayer
    return _affine(x, weight, bias), x @ dweight.mT + dx @ weight.mT + dbias.unsqueeze(-2)
