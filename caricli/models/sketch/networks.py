"""The network that sees faces in sketches: a picture of the strokes, and points along those whose names are given.

After DeepSketch2Face (sketch paper, section 4.3, figure 7): its pixel-level and its shape-level input, at half of the
size and with normalisation, and with linear components of the shape in the place of the bilinear model.
"""

import torch
from torch import nn
from torch.nn import functional

from caricli.models.residual import Residual, start_convolutions, unit
from caricli.models.sketch.config import SketchSize

CAMERA = 6
"""Numbers of the camera: pitch, yaw and roll in radians, logarithm of the scale, and the place of the origin."""

QUARTER = 4
"""Pixels on a side that become one place at once: lines are sharp, and fine levels cost most."""

CELLS = 4
"""Places on a side that the last features are gathered at."""


class SketchNetwork(nn.Module):
    """Windows (B, 1, S, S), ink from 0 to 1, and points along curves to latents and cameras (B, D + 6).

    The last layer's numbers are multiplied by ``step`` and added to ``start``, buffers (D + 6,), so that all are of the
    order of one in it; points come in as distances to ``usual``, a buffer (K, P, 2), over ``spread``, a number.
    """

    start: torch.Tensor
    step: torch.Tensor
    usual: torch.Tensor
    spread: torch.Tensor

    def __init__(self, size: SketchSize, curves: int, points: int, dimension: int, generator: torch.Generator) -> None:
        """curves, points: K and P. dimension: D of the latent. generator: of the initial weights."""
        super().__init__()
        self.size = size
        self.dimension = dimension
        self.stem = unit(QUARTER**2, size.stem)
        inputs = (size.stem, *size.widths)
        levels = zip(inputs, size.widths, size.blocks, strict=False)
        self.down = nn.ModuleList(
            nn.Sequential(unit(before, width, stride=2), *(Residual(width) for _ in range(count)))
            for before, width, count in levels
        )
        self.seen = nn.Linear(size.widths[-1] * CELLS**2, size.hidden)
        self.told = nn.Sequential(
            nn.Linear(curves * (2 * points + 1), size.told), nn.ReLU(), nn.Linear(size.told, size.told), nn.ReLU()
        )
        self.joined = nn.Linear(size.hidden + size.told, size.hidden)
        self.last = nn.Linear(size.hidden, dimension + CAMERA)
        self.register_buffer("start", torch.zeros(dimension + CAMERA))
        self.register_buffer("step", torch.ones(dimension + CAMERA))
        self.register_buffer("usual", torch.zeros(curves, points, 2))
        self.register_buffer("spread", torch.ones(()))
        self._draw_weights(generator)

    def forward(self, windows: torch.Tensor, points: torch.Tensor) -> torch.Tensor:
        """windows: (B, 1, S, S). points: (B, K, P, 2) of the window, NaN where unknown. Returns (B, D + 6)."""
        values = self.stem(functional.pixel_unshuffle(windows, QUARTER))
        for level in self.down:
            values = level(values)
        values = functional.adaptive_avg_pool2d(values, CELLS).flatten(1)
        there = points.isfinite().all(-1, keepdim=True)
        gaps = torch.where(there, (points - self.usual) / self.spread, torch.zeros_like(points))
        told = self.told(torch.cat([gaps.flatten(1), there[:, :, 0, 0].to(gaps.dtype)], 1))
        hidden = torch.cat([functional.relu(self.seen(values)), told], 1)
        return self.start + self.step * self.last(functional.relu(self.joined(hidden))).float()

    def _draw_weights(self, generator: torch.Generator) -> None:
        start_convolutions(self, generator)
        for layer in (self.seen, *self.told, self.joined):
            if isinstance(layer, nn.Linear):
                nn.init.kaiming_normal_(layer.weight, nonlinearity="relu", generator=generator)
                nn.init.zeros_(layer.bias)
        nn.init.zeros_(self.last.weight)
        nn.init.zeros_(self.last.bias)
