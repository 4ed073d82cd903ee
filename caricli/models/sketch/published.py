"""The networks of DeepSketch2Face (sketch paper, sections 4.3 and 6.3, figure 7)."""

from typing import Self

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from caricli.models.bilinear.space import BilinearSpace
from caricli.models.prior import Prior
from caricli.models.residual import start_convolutions, start_linear, start_plainly
from caricli.models.sketch.config import PUBLISHED, PublishedSize
from caricli.models.sketch.networks import CAMERA

SHOWN = 3
"""Every which of a curve's points is one of those whose coefficients are the shape-level input."""

NOISE = 0.02
"""Of half of the window's side: how far drawn points are expected from where they belong."""

_LAYERS = 3
"""Of the branch of u; that of v has one."""

_ROUNDS = 4
"""Steps towards the coefficients of points: more make them more exact, and a training slow."""


class PublishedNetwork(nn.Module):
    """Windows (B, 1, S, S), ink from 0 to 1, and points along curves to codes of a bilinear model and a camera.

    Windows are a canvas on which heads stand where heads usually do, so that the camera is always the same. What the
    last layers give is multiplied by ``step`` and added to ``start``, buffers (D + 6,). The coefficients of points are
    those of another bilinear model, whose numbers are the ``told`` buffers; ``usual`` (K, P, 2) are mean points. With
    ``fixed`` the convolutions stay as they are, statistics of normalisation included.
    """

    start: torch.Tensor
    step: torch.Tensor
    usual: torch.Tensor
    told_core: torch.Tensor
    told_mean: torch.Tensor
    told_factor: torch.Tensor

    def __init__(self, size: PublishedSize, curves: int, points: int, window: int, generator: torch.Generator) -> None:
        """curves, points: K and P. window: side of the windows, pixels. generator: of the initial weights."""
        super().__init__()
        self.size = size
        self.variant = PUBLISHED[size.variant]
        self.dimension = size.identity + size.expression - 1
        self.fixed = False
        if self.variant.pixels:
            self.convolutions = _convolutions(size)
            side = window
            for kernel, stride, margin in ((11, 4, 2), (3, 2, 0), (3, 2, 0), (3, 2, 0)):
                side = (side + 2 * margin - kernel) // stride + 1
            self.shared = nn.Linear(size.widths[-1] * side**2, size.hidden)
            self.of_u = _stack(size.hidden, size.branch, _LAYERS)
            if self.variant.branches:
                self.of_v = _stack(size.hidden, size.branch, 1)
        if self.variant.points:
            self.told_u, self.told_v = (nn.Linear(self.dimension, size.told) for _ in range(2))
        self.width = size.branch * self.variant.pixels + size.told * self.variant.points
        self.last = nn.ModuleList(plain_linear(self.width, count) for count in (size.identity, size.expression - 1))
        self.kinds = nn.ModuleList()
        # In one row, because what has several is kept in half precision.
        count = curves * len(range(0, points, SHOWN)) * 2
        self.register_buffer("told_core", torch.zeros(count * size.identity * size.expression))
        self.register_buffer("told_mean", torch.zeros(self.dimension))
        self.register_buffer("told_factor", torch.eye(self.dimension).flatten())
        self.register_buffer("start", torch.zeros(self.dimension + CAMERA))
        self.register_buffer("step", torch.ones(self.dimension + CAMERA))
        self.register_buffer("usual", torch.zeros(curves, points, 2))
        self._space: BilinearSpace | None = None
        self._draw_weights(generator)

    def train(self, mode: bool = True) -> Self:
        """See torch; convolutions that are fixed stay as in use."""
        super().train(mode)
        if self.fixed and self.variant.pixels:
            self.convolutions.eval()
        return self

    def forward(self, windows: torch.Tensor, points: torch.Tensor) -> torch.Tensor:
        """windows: (B, 1, S, S). points: (B, K, P, 2) of the window, NaN where unknown. Returns (B, D + 6)."""
        return self.tell(windows, torch.from_numpy(self.coefficients(points.numpy())))

    def coefficients(self, points: np.ndarray) -> np.ndarray:
        """The shape-level input (B, D) float32 of points (B, K, P, 2): in standard deviations, 0 where none are known.

        Raises no errors for curves that are not drawn: those that are tell what is likely.
        """
        if not self.variant.points:
            return np.zeros((len(points), self.dimension), np.float32)
        rows = shown_points(points)
        there = np.isfinite(rows)
        space = self._space or self._told_space()
        codes = space.encode(np.where(there, rows, 0), there.astype(float), _ROUNDS)
        return space.prior.whiten(codes).astype(np.float32)

    def tell(self, windows: torch.Tensor, coefficients: torch.Tensor) -> torch.Tensor:
        """Codes and camera (B, D + 6) of windows and their coefficients (B, D)."""
        numbers = [layer(part) for layer, part in zip(self.last, self.hidden(windows, coefficients), strict=True)]
        camera = torch.zeros(len(windows), CAMERA)
        return self.start + self.step * torch.cat([number.float() for number in (*numbers, camera)], 1)

    def classes(self, windows: torch.Tensor, coefficients: torch.Tensor) -> list[torch.Tensor]:
        """Logits of people and of expressions, in the first step of the training."""
        return [layer(part) for layer, part in zip(self.kinds, self.hidden(windows, coefficients), strict=True)]

    def hidden(self, windows: torch.Tensor, coefficients: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """What the last layers of u and of v are given."""
        ends: tuple[list[torch.Tensor], list[torch.Tensor]] = ([], [])
        if self.variant.pixels:
            seen = functional.relu(self.shared(self.convolutions(windows).flatten(1)))
            first = self.of_u(seen)
            ends[0].append(first)
            ends[1].append(self.of_v(seen) if self.variant.branches else first)
        if self.variant.points:
            for end, layer in zip(ends, (self.told_u, self.told_v), strict=True):
                end.append(functional.relu(layer(coefficients)))
        return torch.cat(ends[0], 1), torch.cat(ends[1], 1)

    def kernels(self) -> list[torch.Tensor]:
        """Weights of all layers but the last ones."""
        layers = {name: layer for name, layer in self.named_modules() if isinstance(layer, nn.Conv2d | nn.Linear)}
        return [layer.weight for name, layer in layers.items() if not name.startswith(("last.", "kinds."))]

    def learn_points(self, space: BilinearSpace) -> None:
        """Take the model of points (M,) along curves whose coefficients are the shape-level input."""
        self.told_core.copy_(torch.from_numpy(space.core.ravel()))
        self.told_mean.copy_(torch.from_numpy(space.prior.mean))
        self.told_factor.copy_(torch.from_numpy(space.prior.factor.ravel()))
        self._space = None

    def _told_space(self) -> BilinearSpace:
        core = self.told_core.double().numpy().reshape(-1, self.size.identity, self.size.expression)
        factor = self.told_factor.double().numpy().reshape(2 * (self.dimension,))
        self._space = BilinearSpace(core, Prior(self.told_mean.double().numpy(), factor), NOISE)
        return self._space

    def _draw_weights(self, generator: torch.Generator) -> None:
        start_convolutions(self, generator)
        for layer in self.modules():
            if isinstance(layer, nn.Linear) and not any(layer is last for last in self.last):
                start_linear(layer, generator)


def plain_linear(inputs: int, outputs: int) -> nn.Linear:
    """A layer that gives zeros at first."""
    layer = nn.Linear(inputs, outputs)
    start_plainly(layer)
    return layer


def shown_points(points: np.ndarray) -> np.ndarray:
    """Rows (B, M) of those of points (B, K, P, 2) whose coefficients are the shape-level input."""
    return points[:, :, ::SHOWN].reshape(len(points), -1).astype(float)


def _convolutions(size: PublishedSize) -> nn.Sequential:
    """AlexNet's (Krizhevsky et al. 2012), in one piece."""
    kernels = ((11, 4, 2), (5, 1, 2), (3, 1, 1), (3, 1, 1), (3, 1, 1))
    layers: list[nn.Module] = []
    before = 1
    for number, (width, (kernel, stride, margin)) in enumerate(zip(size.widths, kernels, strict=True)):
        layers.append(nn.Conv2d(before, width, kernel, stride, margin, bias=size.local))
        layers += [nn.ReLU()] if size.local else [nn.BatchNorm2d(width), nn.ReLU()]
        if number < 2 and size.local:
            layers.append(nn.LocalResponseNorm(5, 1e-4, 0.75, 2.0))
        if number in (0, 1, 4):
            layers.append(nn.MaxPool2d(3, 2))
        before = width
    return nn.Sequential(*layers)


def _stack(inputs: int, width: int, count: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for number in range(count):
        layers += [nn.Linear(width if number else inputs, width), nn.ReLU()]
    return nn.Sequential(*layers)
