"""Windows that a detector has learnt from once, looked at anew: mirrored, bent and in other light."""

from collections.abc import Sequence
from dataclasses import replace

import torch
from torch.nn import functional

from caricli.methods.train.detector.detector_losses import FaceTargets
from caricli.methods.train.detector.window_batch import WindowBatch
from caricli.structures.landmarks import MIRRORED
from caricli.structures.parsing import BEYOND

_TURN = 0.1
_SCALE = 0.08
_STRETCH = 0.06
_SHIFT = 0.03
_BEND = 0.012
"""Deviations of what windows of a face that are learnt from again are turned by, radians, scaled and stretched by,
logarithms, and moved and bent by, of the window's side.
"""

_STEPS = 8
"""In which it is found where points went: each leaves a quarter of what was missing."""

_EXPONENT = 0.2
_CONTRAST = 0.15
_BRIGHTNESS = 0.05
_SATURATION = 0.3
_MIX = 0.08
_GRAIN = 0.02
"""Deviations of what a window is lit by when it is learnt from again: of the logarithms of exponent and contrast, of
what is added, of saturation and what colours are mixed by, and of the deviation of grain.
"""


def joined_windows(batches: Sequence[WindowBatch]) -> WindowBatch:
    """The windows of several batches of tensors as one."""
    crops = [len(batch.points) for batch in batches]
    pixels = _faces_first([batch.pixels for batch in batches], crops)
    regions = _faces_first([batch.regions for batch in batches], crops)
    points = torch.cat([batch.points for batch in batches])
    visible = torch.cat([batch.visible for batch in batches])
    targets = FaceTargets(*map(torch.cat, zip(*(batch.targets.parts for batch in batches), strict=True)))
    return WindowBatch(pixels, regions, points, visible, targets)


def _faces_first(parts: Sequence[torch.Tensor], crops: Sequence[int]) -> torch.Tensor:
    """Of every part so many, then the others."""
    pairs = list(zip(parts, crops, strict=True))
    return torch.cat([part[:count] for part, count in pairs] + [part[count:] for part, count in pairs])


def picked_windows(windows: WindowBatch, like: WindowBatch, generator: torch.Generator) -> WindowBatch:
    """As many windows as another batch has, and of its kinds, picked by chance and looked at anew.

    All are mirrored by chance and lit; those of one face are turned, scaled, stretched, moved and bent, too.
    generator: on the windows' device.
    """
    crops = len(like.points)
    faces = _picks(len(windows.points), crops, generator)
    others = _picks(len(windows.targets.heat), len(like.targets.heat), generator)
    rows = torch.cat([faces, len(windows.points) + others])
    targets = FaceTargets(*(part[others] for part in windows.targets.parts))
    picked = WindowBatch(
        windows.pixels[rows], windows.regions[rows], windows.points[faces], windows.visible[faces], targets
    )
    turned = mirrored_windows(picked, _picks(2, len(rows), generator).bool())
    bent = bent_windows(turned, _random_moves(crops, turned.pixels.shape[1], generator))
    return replace(bent, pixels=_lit(bent.pixels, generator))


def _picks(count: int, size: int, generator: torch.Generator) -> torch.Tensor:
    return torch.randint(count, (size,), generator=generator, device=generator.device)


def _random_moves(count: int, size: int, generator: torch.Generator) -> torch.Tensor:
    """(C, S, S, 2) pixels from the places of windows to where they are taken from."""

    def normal(*shape: int) -> torch.Tensor:
        return torch.randn(count, *shape, generator=generator, device=generator.device)

    turn = _TURN * normal(1, 1) * torch.tensor([[0.0, -1.0], [1.0, 0.0]], device=generator.device)
    scale = _SCALE * normal(1, 1) * torch.eye(2, device=generator.device)
    linear = torch.matrix_exp(turn + scale + _STRETCH * normal(2, 2)) - torch.eye(2, device=generator.device)
    places = torch.arange(size, device=generator.device) - (size - 1) / 2
    across, down = torch.meshgrid(places, places, indexing="xy")
    affine = torch.stack([across, down], -1) @ linear[:, None].mT + _SHIFT * size * normal(1, 1, 2)
    knots = _BEND * size * normal(2, 5, 5)
    bend = functional.interpolate(knots, (size, size), mode="bicubic", align_corners=True)
    return affine + bend.permute(0, 2, 3, 1)


def bent_windows(windows: WindowBatch, moves: torch.Tensor) -> WindowBatch:
    """Windows of which the first C, those of one face, are taken from elsewhere.

    moves: (C, S, S, 2) pixels from their places to where they come from.
    """
    crops, size = moves.shape[:2]
    places = torch.arange(size, device=moves.device)
    sources = torch.stack(torch.meshgrid(places, places, indexing="xy"), -1) + moves
    shares = (2 * sources + 1) / size - 1
    pixels = windows.pixels[:crops].permute(0, 3, 1, 2).float()
    pixels = functional.grid_sample(pixels, shares, padding_mode="border", align_corners=False)
    # What lies beyond the window has the region after the last.
    regions = windows.regions[:crops, None].float() - BEYOND
    regions = functional.grid_sample(regions, shares, mode="nearest", align_corners=False)[:, 0] + BEYOND
    return replace(
        windows,
        pixels=torch.cat([pixels.round().to(torch.uint8).permute(0, 2, 3, 1), windows.pixels[crops:]]),
        regions=torch.cat([regions.to(torch.uint8), windows.regions[crops:]]),
        points=_gone(windows.points, moves),
    )


def _gone(points: torch.Tensor, moves: torch.Tensor) -> torch.Tensor:
    """Where points (C, L, 2) are in windows that are taken from elsewhere."""
    size = moves.shape[1]
    fields = moves.permute(0, 3, 1, 2)
    places = points
    # What is at p comes from p + moves(p).
    for _ in range(_STEPS):
        shares = (2 * places[:, None] + 1) / size - 1
        moved = functional.grid_sample(fields, shares, padding_mode="border", align_corners=False)
        places = points - moved[:, :, 0].mT
    return places


def mirrored_windows(windows: WindowBatch, which: torch.Tensor) -> WindowBatch:
    """Windows of which some, (B,) bool, are mirrored."""
    crops = len(windows.points)
    size = windows.pixels.shape[2]
    flip = which[:, None, None]
    order = torch.tensor(MIRRORED, device=which.device)
    away = torch.tensor([size - 1, 0], device=which.device)
    points = (away + windows.points * torch.tensor([-1.0, 1.0], device=which.device))[:, order]
    targets = windows.targets
    signs = torch.tensor([-1.0, 1, 1, 1, -1], device=which.device)[:, None, None]
    grids = [torch.where(flip[crops:], part.flip(-1), part) for part in (targets.heat, targets.counts, targets.near)]
    values = torch.where(flip[crops:, None], targets.values.flip(-1) * signs, targets.values)
    return WindowBatch(
        torch.where(flip[..., None], windows.pixels.flip(2), windows.pixels),
        torch.where(flip, windows.regions.flip(2), windows.regions),
        torch.where(flip[:crops], points, windows.points),
        torch.where(which[:crops, None], windows.visible[:, order], windows.visible),
        FaceTargets(grids[0], grids[1], values, grids[2]),
    )


def _lit(pixels: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    """Pixels (B, S, S, 3) uint8 in other light and in colours that are mixed from one another."""

    def normal(*shape: int) -> torch.Tensor:
        return torch.randn(len(pixels), *shape, generator=generator, device=generator.device)

    saturation = 1 + _SATURATION * normal(1, 1)
    mix = saturation * torch.eye(3, device=generator.device) + (1 - saturation) / 3 + _MIX * normal(3, 3)
    mix = mix / mix.sum(2, keepdim=True)
    values = (pixels.flatten(1, 2).float() / 255).clamp_min(1e-3) ** torch.exp(_EXPONENT * normal(1, 1)) @ mix.mT
    contrast = torch.exp(_CONTRAST * normal(1, 1))
    values = (values - 0.5) * contrast + 0.5 + _BRIGHTNESS * normal(1, 1)
    values = values + _GRAIN * normal(1, 1) * normal(*values.shape[1:])
    return (255 * values).round().clamp(0, 255).to(torch.uint8).view_as(pixels)
