"""What textures of other expressions are made by, besides the network, and read by."""

import numpy as np
import torch
from scipy.interpolate import RBFInterpolator
from torch import nn
from torch.nn import functional

from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.own_manner import MannerReader
from caricli.methods.dynamic.shape_maps import CHANNELS, PART
from caricli.methods.evaluate.evaluate_texture import Painter
from caricli.methods.train.texture.texture_losses import TextureBatch
from caricli.methods.train.texture.texture_pairs import TexturePairs
from caricli.models.residual import start_convolutions, unit
from caricli.models.texture.model import TextureModel
from caricli.template.head import load_head

_PAIRS = 60
"""Batches that what is linear is fitted to."""

_BATCH = 32
_RIDGE = 1.0
"""Of the fit, in variances of weights."""

_RATE = 2e-3


def network_painter(model: TextureModel, grid: ChartGrid) -> Painter:
    """What a network makes of a batch."""
    reader = MannerReader(grid, load_head().template())
    share, skin = (torch.from_numpy(part) for part in (reader.share, reader.skin))

    def paint(batch: TextureBatch) -> torch.Tensor:
        pictures = (255 * batch.source).permute(0, 2, 3, 1).numpy()
        manners = [reader.read(picture) for picture in pictures]
        shades = torch.from_numpy(np.stack([manner.shades for manner in manners]))
        deepest = torch.tensor([manner.deepest for manner in manners])
        change = batch.change(model.network).in_own_shades(batch.source, shades, share)
        coloured = torch.tensor([manner.coloured for manner in manners])
        change = change.with_folds_up_to(batch.source, deepest, shades, skin).toned(coloured)
        return change.paint(batch.source).clamp(0, 1)

    return paint


def linear_painter(pairs: TexturePairs, seed: int) -> Painter:
    """The mean change of two expressions: that which is linear in the difference of their codes, fitted to pairs."""
    generator = np.random.default_rng(seed)
    steps = []
    changes = []
    for _ in range(_PAIRS):
        batch = pairs.draw(_BATCH, generator, paired=True)
        steps.append(batch.target_code - batch.source_code)
        changes.append((batch.target - batch.source).flatten(1))
    step = torch.cat(steps)
    table = torch.linalg.solve(step.T @ step + _RIDGE * torch.eye(step.shape[1]), step.T @ torch.cat(changes))

    def paint(batch: TextureBatch) -> torch.Tensor:
        change = (batch.target_code - batch.source_code) @ table
        return (batch.source + change.view_as(batch.source)).clamp(0, 1)

    return paint


def spline_painter(grid: ChartGrid, landmarks: np.ndarray) -> Painter:
    """The texture as a picture of it shows it that is warped from landmarks to landmarks (expressions paper, 4.3.2).

    The warp is a thin-plate spline over the chart. Where the face moves as the spline between the landmarks does, the
    texture stays as it is; elsewhere the picture's paint slides over the face.
    grid: ChartGrid. landmarks: (L,) vertices of the mesh; those of the chart count.
    """
    chart = grid.chart
    places = chart.uvs[np.isin(chart.vertices, landmarks)] * [grid.size, -grid.size] + [-0.5, grid.size - 0.5]
    inside = np.argwhere(grid.covered)[:, ::-1]
    knots = np.unique(inside[((places[:, None] - inside) ** 2).sum(2).argmin(1)], axis=0)
    spline = RBFInterpolator(knots, np.eye(len(knots)), kernel="thin_plate_spline")
    texels = np.stack(np.meshgrid(np.arange(grid.size), np.arange(grid.size)), -1)
    shares = torch.from_numpy(spline(texels.reshape(-1, 2)).astype(np.float32))
    channels = [CHANNELS.index(f"displacement_{axis}") for axis in "xy"]
    # From quarters of the face's width to halves of the chart's side, in which pictures are sampled; rows go down.
    scale = PART * float(np.ptp(chart.uvs[:, 0])) * 2 * torch.tensor([1.0, -1.0])
    still = torch.from_numpy(((texels + 0.5) * 2 / grid.size - 1).astype(np.float32))

    def paint(batch: TextureBatch) -> torch.Tensor:
        moved = batch.forth[:, channels].permute(0, 2, 3, 1)
        warped = shares @ moved[:, knots[:, 1], knots[:, 0]]
        slid = still + scale * (moved - warped.view_as(moved))
        return functional.grid_sample(batch.source, slid, padding_mode="border", align_corners=False)

    return paint


class ExpressionReader(nn.Module):
    """Tells how the weights of ARKit's actions change from one texture to another: a judge apart from all painters.

    It reads both, because a single texture shows who somebody is, and in which light, far more than what the face does.
    """

    def __init__(self, actions: int, generator: torch.Generator) -> None:
        """actions: how many weights. generator: of the initial weights."""
        super().__init__()
        widths = (6, 32, 48, 64, 96)
        self.down = nn.Sequential(*(unit(a, b, stride=2) for a, b in zip(widths[:-1], widths[1:], strict=True)))
        self.last = nn.LazyLinear(actions)
        start_convolutions(self, generator)

    def forward(self, batch: TextureBatch, pictures: torch.Tensor) -> torch.Tensor:
        """The weights (B, A) in pictures (B, 3, S, S), sRGB from 0 to 1, of batch's sources with other expressions."""
        both = torch.cat([batch.source, pictures], 1)
        return batch.source_code + self.last(self.down(2 * both - 1).flatten(1))


def train_reader(pairs: TexturePairs, seed: int, steps: int = 1500) -> ExpressionReader:
    """Train an ExpressionReader on true textures, in so many steps."""
    generator = np.random.default_rng(seed)
    start = torch.Generator().manual_seed(seed)
    batch = pairs.draw(_BATCH, generator, paired=True)
    reader = ExpressionReader(batch.target_code.shape[1], start)
    reader(batch, batch.target)
    nn.init.normal_(reader.last.weight, std=0.01, generator=start)
    nn.init.zeros_(reader.last.bias)
    optimiser = torch.optim.AdamW(reader.parameters(), lr=_RATE)
    for step in range(steps):
        batch = pairs.draw(_BATCH, generator, paired=True)
        optimiser.zero_grad()
        functional.mse_loss(reader(batch, batch.target), batch.target_code).backward()
        optimiser.param_groups[0]["lr"] = _RATE * (1 - step / steps)
        optimiser.step()
    return reader.eval()
