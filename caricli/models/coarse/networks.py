"""The coarse network: a residual network from a picture to the coefficients of the morphable model.

Portrait paper, section 3.1.2 and 4.1. Beside the picture it may be told where the landmarks are, which a detector has
seen in it.
"""

from collections.abc import Mapping

import torch
from torch import nn
from torch.nn import functional

from caricli.models.coarse.config import CoarseSize
from caricli.models.residual import Bottleneck, Residual, start_convolutions, unit

CELLS = 4
"""Places on a side that the last features are gathered at."""

SPREAD = 0.06
"""Of a window's side: how far landmarks are from their usual places, so that numbers of about one come in."""


class CoarseNetwork(nn.Module):
    """Windows (B, 3, S, S), sRGB from 0 to 1, with landmarks to coefficients (B, D).

    The last layer's numbers are multiplied by ``step`` and added to ``start``, buffers (D,), so that angles, pixels and
    standard deviations all are of the order of one in it; landmarks come in as distances to ``usual``, a buffer (L, 2).
    ``doubt``, a buffer (D,), is how far they usually are from true ones.
    """

    start: torch.Tensor
    step: torch.Tensor
    usual: torch.Tensor
    doubt: torch.Tensor

    def __init__(self, size: CoarseSize, landmarks: int, outputs: int, generator: torch.Generator) -> None:
        """landmarks: L. outputs: D. generator: of the initial weights."""
        super().__init__()
        block = Bottleneck if size.bottleneck else Residual
        self.size = size
        self.outputs = outputs
        self.stem = unit(12, size.stem)
        inputs = (size.stem, *size.widths)
        levels = zip(inputs, size.widths, size.blocks, strict=False)
        self.down = nn.ModuleList(
            nn.Sequential(unit(before, width, stride=2), *(block(width) for _ in range(count)))
            for before, width, count in levels
        )
        self.gather = unit(size.widths[-1], size.kept, kernel=1)
        told = 3 * landmarks if size.landmarks else 0
        self.hidden = nn.Linear(size.kept * CELLS**2 + told, size.hidden)
        self.last = nn.Linear(size.hidden + told, outputs)
        self.register_buffer("start", torch.zeros(outputs))
        self.register_buffer("step", torch.ones(outputs))
        self.register_buffer("usual", torch.zeros(landmarks, 2))
        self.register_buffer("doubt", torch.ones(outputs))
        self._draw_weights(generator)

    def forward(self, windows: torch.Tensor, points: torch.Tensor) -> torch.Tensor:
        """windows: (B, 3, S, S). points: (B, L, 2) shares of the window's side, NaN where unknown. Returns (B, D)."""
        return self.tell(self.encode(windows), points)

    def encode(self, windows: torch.Tensor) -> torch.Tensor:
        """Windows (B, 3, S, S) to features (B, C, S / 32, S / 32)."""
        values = self.stem(functional.pixel_unshuffle(2 * windows - 1, 2))
        for level in self.down:
            values = level(values)
        return values

    def tell(self, features: torch.Tensor, points: torch.Tensor) -> torch.Tensor:
        """Features and landmarks to coefficients (B, D)."""
        values = functional.adaptive_avg_pool2d(self.gather(features), CELLS).flatten(1).float()
        with torch.autocast(values.device.type, enabled=False):
            told = self._told(points) if self.size.landmarks else values[:, :0]
            hidden = functional.relu(self.hidden(torch.cat([values, told], 1)))
            return self.start + self.step * self.last(torch.cat([hidden, told], 1))

    def borrow(self, weights: Mapping[str, torch.Tensor]) -> bool:
        """Take over the encoder of another network, if it has one of the same size. Returns whether it has."""
        own = {name: value for name, value in self.state_dict().items() if name.startswith(("stem.", "down."))}
        fits = all(name in weights and weights[name].shape == value.shape for name, value in own.items())
        if fits:
            for name, value in own.items():
                value.copy_(weights[name])
        return fits

    def _told(self, points: torch.Tensor) -> torch.Tensor:
        """(B, 3 L) what it is told of landmarks: distances to their usual places, and whether they are known."""
        there = points.isfinite().all(-1, keepdim=True)
        gaps = torch.where(there, (points - self.usual) / SPREAD, torch.zeros_like(points))
        return torch.cat([gaps, there.float()], -1).flatten(1)

    def _draw_weights(self, generator: torch.Generator) -> None:
        start_convolutions(self, generator)
        nn.init.kaiming_normal_(self.hidden.weight, nonlinearity="relu", generator=generator)
        nn.init.zeros_(self.hidden.bias)
        nn.init.zeros_(self.last.weight)
        nn.init.zeros_(self.last.bias)
