"""The coarse network: a residual network from a picture to the coefficients of the morphable model.

Portrait paper, section 3.1.2 and 4.1. Beside the picture it may be told where the landmarks are, which a detector has
seen in it, and how sure of them it is; then it looks at the picture there, too.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import torch
from torch import nn
from torch.nn import functional

from caricli.models.coarse.config import CoarseSize
from caricli.models.residual import (
    Bottleneck,
    Residual,
    encoder_levels,
    start_convolutions,
    start_linear,
    start_plainly,
    unit,
)

CELLS = 4
"""Places on a side that the last features are gathered at."""

SPREAD = 0.06
"""Of a window's side: how far landmarks are from their usual places, so that numbers of about one come in."""

DOUBT = 0.02
"""Of a window's side: the usual standard deviation of a landmark's error."""

_LEAST = 0.1
"""Of the usual one, what is added to a standard deviation before its logarithm is taken."""

_GLANCE = 1
"""Level of the encoder at which it looks at landmarks."""

TOLD = 5
"""Numbers of a landmark: place x and y, shares of the window's side, and their variances and covariance."""


@dataclass(frozen=True, eq=False)
class WindowFeatures:
    """What an encoder makes of B windows.

    whole: (B, C, 4, 4) of the last level. near: (B, L, C') of a finer one at landmarks, or (B, 0, C').
    """

    whole: torch.Tensor
    near: torch.Tensor


class CoarseNetwork(nn.Module):
    """Windows (B, 3, S, S), sRGB from 0 to 1, with landmarks to coefficients (B, D).

    The last layer's numbers are multiplied by ``step`` and added to ``start``, buffers (D,), so that angles, pixels and
    standard deviations all are of the order of one in it; landmarks come in as distances to ``usual``, a buffer (L, 2).
    What landmarks tell, and what the picture does beside them, are added.
    ``doubt``, a buffer (D,), is how far they usually are from true ones.
    """

    start: torch.Tensor
    step: torch.Tensor
    usual: torch.Tensor
    doubt: torch.Tensor

    def __init__(self, size: CoarseSize, landmarks: int, outputs: int, generator: torch.Generator) -> None:
        """landmarks: L. outputs: D. generator: of the initial weights."""
        super().__init__()
        self.size = size
        self.outputs = outputs
        self.stem = unit(12, size.stem)
        block = Bottleneck if size.bottleneck else Residual
        self.down = encoder_levels(size.stem, size.widths, size.blocks, block)
        self.gather = unit(size.widths[-1], size.kept, kernel=1)
        told = (TOLD + 2) * landmarks if size.landmarks else 0
        self.hidden = nn.Linear(size.kept * CELLS**2 + size.glance * landmarks + told, size.hidden)
        self.last = nn.Linear(size.hidden, outputs)
        if told:
            self.told_hidden = nn.Linear(told, size.hidden)
            self.told_last = nn.Linear(size.hidden + told, outputs)
        if size.glance:
            self.near = nn.Parameter(torch.empty(landmarks, size.widths[_GLANCE], size.glance))
        self.register_buffer("start", torch.zeros(outputs))
        self.register_buffer("step", torch.ones(outputs))
        self.register_buffer("usual", torch.zeros(landmarks, 2))
        self.register_buffer("doubt", torch.ones(outputs))
        self._draw_weights(generator)

    def forward(self, windows: torch.Tensor, marks: torch.Tensor) -> torch.Tensor:
        """windows: (B, 3, S, S). marks: (B, L, 5) see TOLD, NaN where unknown. Returns (B, D)."""
        return self.tell(self.encode(windows, marks), marks)

    def encode(self, windows: torch.Tensor, marks: torch.Tensor) -> WindowFeatures:
        """What is to be seen in windows (B, 3, S, S), and in them at landmarks (B, L, 5)."""
        values = self.stem(functional.pixel_unshuffle(2 * windows - 1, 2))
        near = values.new_zeros(len(values), 0, 1)
        for number, level in enumerate(self.down):
            values = level(values)
            if number == _GLANCE and self.size.glance:
                near = self._at_landmarks(values, marks)
        return WindowFeatures(functional.adaptive_avg_pool2d(values, CELLS), near)

    def tell(self, features: WindowFeatures, marks: torch.Tensor) -> torch.Tensor:
        """Coefficients (B, D) of B landmarks (B, L, 5), of which the first N <= B have features."""
        count = len(features.whole)
        values = self.gather(features.whole).flatten(1).float()
        with torch.autocast(values.device.type, enabled=False):
            told = self._told(marks) if self.size.landmarks else values.new_zeros(len(marks), 0)
            near = features.near.float().flatten(1)
            if self.size.glance:
                near = torch.einsum("blc,lck->blk", features.near.float(), self.near).relu().flatten(1)
            seen = self.last(functional.relu(self.hidden(torch.cat([values, near, told[:count]], 1))))
            numbers = functional.pad(seen, (0, 0, 0, len(marks) - count))
            if self.size.landmarks:
                hidden = functional.relu(self.told_hidden(told))
                numbers = numbers + self.told_last(torch.cat([hidden, told], 1))
            return self.start + self.step * numbers

    def borrow(self, weights: Mapping[str, torch.Tensor]) -> bool:
        """Take over the encoder of another network, if it has one of the same size. Returns whether it has."""
        own = {name: value for name, value in self.state_dict().items() if name.startswith(("stem.", "down."))}
        fits = all(name in weights and weights[name].shape == value.shape for name, value in own.items())
        if fits:
            for name, value in own.items():
                value.copy_(weights[name])
        return fits

    def _told(self, marks: torch.Tensor) -> torch.Tensor:
        """(B, 7 L) numbers of about one: distances to usual places, how sure they are, and whether both are known."""
        there = marks[..., :2].isfinite().all(-1, keepdim=True)
        sure = marks.isfinite().all(-1, keepdim=True)
        gaps = (marks[..., :2] - self.usual) / SPREAD
        deviations = marks[..., 2:4].clamp(min=0).sqrt()
        widths = torch.log(deviations / DOUBT + _LEAST)
        slant = marks[..., 4:] / (deviations.prod(-1, keepdim=True) + (_LEAST * DOUBT) ** 2)
        nothing = marks.new_zeros(())
        doubts = torch.where(sure, torch.cat([widths, slant], -1), nothing)
        return torch.cat([torch.where(there, gaps, nothing), doubts, there.float(), sure.float()], -1).flatten(1)

    def _at_landmarks(self, values: torch.Tensor, marks: torch.Tensor) -> torch.Tensor:
        """(B, L, C) features (B, C, h, w) at landmarks, at their usual places where they are not known."""
        places = torch.where(marks[..., :2].isfinite(), marks[..., :2], self.usual)
        grid = (2 * places - 1)[:, :, None].to(values.dtype)
        near = functional.grid_sample(values, grid, padding_mode="border", align_corners=False)
        return near[..., 0].mT

    def _draw_weights(self, generator: torch.Generator) -> None:
        start_convolutions(self, generator)
        if self.size.glance:
            nn.init.normal_(self.near, std=self.near.shape[1] ** -0.5, generator=generator)
        for name, layer in self.named_children():
            if isinstance(layer, nn.Linear) and name.endswith("hidden"):
                start_linear(layer, generator)
            elif isinstance(layer, nn.Linear):
                start_plainly(layer)
