"""The network that tells what strokes draw: all of them in a picture, and what it says read off along each."""

import torch
from torch import nn
from torch.nn import functional

from caricli.models.residual import Residual, start_convolutions, start_linear, start_plainly, twice, unit
from caricli.models.strokes.config import StrokeSize

QUARTER = 4
"""Pixels on a side that become one place at once: lines are sharp, and fine levels cost most."""

ABOUT = 4
"""Numbers that are told of a place: where it is in the window, from -1 to 1, x right and y down, and cosine and sine of
twice the direction of its line."""


class StrokeNetwork(nn.Module):
    """Windows (B, 1, S, S), ink from 0 to 1, and places along lines in them (B, P, 4), see ABOUT, to logits (B, P, C).

    An encoder and a decoder whose levels are added (Ronneberger et al. 2015), a quarter as fine as the window. A place
    has what they say there, the ink around it as it is, for lines that lie close together, and what is told of it.
    """

    def __init__(self, size: StrokeSize, classes: int, generator: torch.Generator) -> None:
        """classes: C. generator: of the initial weights."""
        super().__init__()
        self.size = size
        widths = size.widths
        before = (QUARTER**2, *widths)
        self.down = nn.ModuleList(
            nn.Sequential(
                unit(before[level], widths[level], stride=2 if level else 1),
                *(Residual(widths[level]) for _ in range(size.blocks[level])),
            )
            for level in range(len(widths))
        )
        self.narrow = nn.ModuleList(
            unit(widths[level + 1], widths[level], kernel=1) for level in range(len(widths) - 1)
        )
        self.up = nn.ModuleList(unit(width, width) for width in widths[:-1])
        self.near = nn.Linear(size.patch**2, widths[0])
        self.first = nn.Linear(2 * widths[0] + ABOUT, size.told)
        self.second = nn.Linear(size.told, size.told)
        self.last = nn.Linear(size.told, classes)
        start_convolutions(self, generator)
        for layer in (self.near, self.first, self.second):
            start_linear(layer, generator)
        start_plainly(self.last)

    def forward(self, windows: torch.Tensor, places: torch.Tensor) -> torch.Tensor:
        """See the class."""
        levels = []
        values = functional.pixel_unshuffle(windows, QUARTER).contiguous(memory_format=torch.channels_last)
        for level in self.down:
            values = level(values)
            levels.append(values)
        for number in reversed(range(len(self.up))):
            values = self.up[number](levels[number] + twice(self.narrow[number](values)))
        seen = _read(values.float(), places, windows.shape[-1])
        around = self.near(_patches(windows, places, self.size.patch))
        told = torch.cat([seen, around, places], 2)
        told = functional.relu(self.first(told))
        return self.last(functional.relu(self.second(told)))


def _read(values: torch.Tensor, places: torch.Tensor, side: int) -> torch.Tensor:
    """(B, P, C) of values (B, C, h, w) at places in windows of some pixels, between those around them."""
    # Places are told from the centre of the first pixel to that of the last; what is read, from border to border.
    grid = places[:, :, None, :2] * (side - 1) / side
    return functional.grid_sample(values, grid, align_corners=False)[..., 0].transpose(1, 2)


def _patches(windows: torch.Tensor, places: torch.Tensor, patch: int) -> torch.Tensor:
    """(B, P, patch²) ink around places, nothing beyond the window."""
    side = windows.shape[-1]
    padded = functional.pad(windows[:, 0], [patch // 2] * 4)
    pixels = ((side - 1) / 2 * (1 + places[..., :2])).round().long().clamp(0, side - 1)
    reach = torch.arange(patch, device=windows.device)
    rows = pixels[..., 1, None, None] + reach[:, None]
    columns = pixels[..., 0, None, None] + reach
    batch = torch.arange(len(windows), device=windows.device)[:, None, None, None]
    return padded[batch, rows, columns].flatten(2)
