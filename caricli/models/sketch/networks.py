"""The network that sees faces in sketches: by points along the strokes whose names are given, else by their picture.

After DeepSketch2Face (sketch paper, section 4.3, figure 7): its shape-level and its pixel-level input, with linear
components of the shape in the place of the bilinear model. A picture says nothing that points along all its strokes do
not say more exactly; so it counts where no name is given, and nothing has to be drawn where one is.
"""

from itertools import pairwise

import torch
from torch import nn
from torch.nn import functional

from caricli.models.residual import Residual, encoder_levels, start_convolutions, start_linear, start_plainly, unit
from caricli.models.sketch.config import SketchSize
from caricli.models.sketch.line_space import LineSpace

CAMERA = 6
"""Numbers of the camera: pitch, yaw and roll in radians, logarithm of the scale, and the place of the origin."""

QUARTER = 4
"""Pixels on a side that become one place at once: lines are sharp, and fine levels cost most."""

CELLS = 4
"""Places on a side that the last features are gathered at."""


_RIDGE = 1e-3
"""Of the linear beginning, in variances of its numbers."""


class SketchNetwork(nn.Module):
    """Windows (B, 1, S, S), ink from 0 to 1, and points along curves to latents and cameras (B, D + 6).

    What the last layers give is multiplied by ``step`` and added to ``start``, buffers (D + 6,), so that all are of the
    order of one in them. Points are told as numbers of a LineSpace, what these leave of every curve, which is how
    unsteady the hand was, and which curves are drawn. What the numbers tell linearly has a layer of its own.
    """

    start: torch.Tensor
    step: torch.Tensor

    def __init__(self, size: SketchSize, curves: int, points: int, dimension: int, generator: torch.Generator) -> None:
        """curves, points: K and P. dimension: D of the latent. generator: of the initial weights."""
        super().__init__()
        self.size = size
        self.dimension = dimension
        self.stem = unit(QUARTER**2, size.stem)
        self.down = encoder_levels(size.stem, size.widths, size.blocks, Residual)
        self.seen = nn.Linear(size.widths[-1] * CELLS**2, size.hidden)
        self.last = nn.Linear(size.hidden, dimension + CAMERA)
        self.lines = LineSpace(curves, points, size.components)
        told = (size.components + 2 * curves, size.told, size.told)
        self.told = nn.ModuleList(nn.Linear(before, after) for before, after in pairwise(told))
        self.plain = nn.Linear(size.components, dimension + CAMERA)
        self.more = nn.Linear(size.told, dimension + CAMERA)
        self.register_buffer("start", torch.zeros(dimension + CAMERA))
        self.register_buffer("step", torch.ones(dimension + CAMERA))
        self._draw_weights(generator)

    @property
    def usual(self) -> torch.Tensor:
        """(K, P, 2) where points usually are."""
        return self.lines.usual

    def forward(self, windows: torch.Tensor, points: torch.Tensor) -> torch.Tensor:
        """windows: (B, 1, S, S), looked at where nothing is told. points: (B, K, P, 2) of the window, NaN where
        unknown. Returns (B, D + 6).
        """
        there = points.isfinite().all(-1).all(-1)
        told = there.any(1)
        numbers = torch.zeros(len(points), len(self.start))
        if told.any():
            numbers[told] = self.by_points(points[told], there[told])
        if not told.all():
            numbers[~told] = self.start + self.step * self.by_picture(windows[~told]).float()
        return numbers

    def by_picture(self, windows: torch.Tensor) -> torch.Tensor:
        """(B, D + 6) in steps, of windows (B, 1, S, S)."""
        values = self.stem(functional.pixel_unshuffle(windows, QUARTER))
        for level in self.down:
            values = level(values)
        values = functional.adaptive_avg_pool2d(values, CELLS).flatten(1)
        return self.last(functional.relu(self.seen(values)))

    def by_points(self, points: torch.Tensor, there: torch.Tensor) -> torch.Tensor:
        """(B, D + 6) of points (B, K, P, 2) along curves of which ``there`` (B, K) are drawn."""
        # Half precision would lose the small differences between faces that look nearly the same.
        with torch.autocast("cpu", enabled=False):
            placed, scale, shift = self.lines.placed(points, there)
            numbers, left = self.lines(placed, there)
            hidden = torch.cat([numbers, left, there.to(numbers.dtype)], 1)
            for layer in self.told:
                hidden = functional.relu(layer(hidden))
            told = self.start + self.step * (self.plain(numbers) + self.more(hidden))
            # Back into the window: the camera's scale, and the place of the origin.
            place = (told[:, -2:] - shift) / scale[:, None]
            return torch.cat([told[:, :-3], told[:, -3:-2] - scale.log()[:, None], place], 1)

    def learn_plainly(self, numbers: torch.Tensor, targets: torch.Tensor) -> None:
        """Begin with what numbers (N, M) of lines tell of targets (N, D + 6) linearly."""
        with torch.no_grad():
            gaps = (targets - self.start) / self.step
            system = numbers.T @ numbers + _RIDGE * len(numbers) * torch.eye(numbers.shape[1])
            self.plain.weight.copy_(torch.linalg.solve(system, numbers.T @ gaps).T)

    def _draw_weights(self, generator: torch.Generator) -> None:
        start_convolutions(self, generator)
        for layer in (self.seen, *self.told):
            assert isinstance(layer, nn.Linear)
            start_linear(layer, generator)
        for layer in (self.last, self.plain, self.more):
            start_plainly(layer)
