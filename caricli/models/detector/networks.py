"""The detector's network: a U-Net, and heads for faces, landmarks and regions that share it.

Landmarks are heat maps whose mean is the place and whose second moments are the doubt, as far as the network itself
knows it; faces are found on a coarse grid, each at the cell of its centre (Zhou et al. 2019, Objects as points).
"""

from dataclasses import dataclass
from functools import partial
from typing import Any

import torch
from torch import nn
from torch.nn import functional

from caricli.models.detector.config import HALF, DetectorSize
from caricli.models.detector.model import LANDMARKS, Detector
from caricli.models.detector.weights import DetectorWeights
from caricli.models.network_weights import load_network, network_weights
from caricli.models.residual import Residual, start_convolutions, twice, unit
from caricli.structures.parsing import Region

_RARE = -4.0
"""Logit of a face anywhere, before the training: they are rare."""


@dataclass(frozen=True, eq=False)
class FaceGrid:
    """What a window shows of faces at every cell of the grid.

    score: (B, h, w) logits. shift: (B, 2, h, w) from the cell's centre to the face's, cells. size: (B, h, w) binary
    logarithm of the face's side over REACH pixels. turn: (B, 2, h, w) cosine and sine of the roll, not of length one.
    """

    score: torch.Tensor
    shift: torch.Tensor
    size: torch.Tensor
    turn: torch.Tensor


@dataclass(frozen=True, eq=False)
class HeatMaps:
    """What a window shows of landmarks.

    logits: (B, L, h, w). mean: (B, L, 2) cells, x and y, 0 at the centre of the first. log_sum: (B, L) logarithm of
    the sum of the exponentials. covariance: (B, L, 2, 2) square cells, calibrated. visible: (B, L) logits.
    """

    logits: torch.Tensor
    mean: torch.Tensor
    log_sum: torch.Tensor
    covariance: torch.Tensor
    visible: torch.Tensor


class DetectorNetwork(nn.Module):
    """Windows of pictures to faces, landmarks and regions.

    Windows are (B, 3, H, W), sRGB from 0 to 1, their sides multiples of 32 pixels.
    """

    def __init__(self, size: DetectorSize, landmarks: int, regions: int, generator: torch.Generator | None) -> None:
        """landmarks, regions: how many there are. generator: of the initial weights; None where they are loaded."""
        super().__init__()
        first, second, third, fourth = size.widths
        self.size = size
        self.landmarks = landmarks
        self.stem = unit(3 * HALF**2, size.stem)
        self.down = nn.ModuleList(
            [
                nn.Sequential(unit(size.stem, first, stride=2), Residual(first)),
                nn.Sequential(unit(first, second, stride=2), Residual(second)),
                nn.Sequential(unit(second, third, stride=2), *(Residual(third) for _ in range(size.depth))),
                nn.Sequential(unit(third, fourth, stride=2), *(Residual(fourth) for _ in range(size.depth))),
            ]
        )
        self.up = nn.ModuleList([unit(b, a, kernel=1) for a, b in ((third, fourth), (second, third), (first, second))])
        self.join = nn.ModuleList([Residual(width) for width in (third, second, first)])
        self.finer = nn.ModuleList([Residual(first) for _ in range(size.finer)])
        self.near_face = unit(third, first)
        self.face = nn.Conv2d(first, 6, 1)
        self.heat = nn.Conv2d(first, landmarks, 1)
        self.about = nn.Parameter(torch.empty(landmarks, first, 3))
        self.about_bias = nn.Parameter(torch.zeros(landmarks, 3))
        self.regions = nn.Conv2d(first, HALF**2 * regions, 1)
        self.edges = nn.Conv2d(HALF**2 * size.stem, HALF**2 * regions, 1)
        _start(self, generator)

    def coarse(self, windows: torch.Tensor) -> tuple[torch.Tensor, list[torch.Tensor]]:
        """Features on the grid of faces, and those of the finer levels that ``fine`` joins them with."""
        levels = [self.stem(functional.pixel_unshuffle(2 * windows - 1, HALF))]
        for step in self.down:
            levels.append(step(levels[-1]))
        lowest = levels.pop()
        return self.join[0](levels.pop() + twice(self.up[0](lowest))), levels

    def faces(self, features: torch.Tensor) -> FaceGrid:
        """The faces of features on the grid."""
        values = self.face(self.near_face(features)).float()
        return FaceGrid(values[:, 0], values[:, 1:3], values[:, 3], values[:, 4:6])

    def fine(self, features: torch.Tensor, levels: list[torch.Tensor]) -> torch.Tensor:
        """Features at a quarter of the windows' size."""
        for up, join, level in zip(self.up[1:], self.join[1:], reversed(levels[1:]), strict=True):
            features = join(level + twice(up(features)))
        for block in self.finer:
            features = block(features)
        return features

    def parse(self, features: torch.Tensor, levels: list[torch.Tensor]) -> torch.Tensor:
        """Logits of regions (B, h, w, 4, R) of fine features, for the four pixels of half size in every cell, by rows.

        They stay so, because turned into a picture they would be copied three times in a step of the training.
        """
        values = self.regions(features) + self.edges(functional.pixel_unshuffle(levels[0], HALF))
        return values.permute(0, 2, 3, 1).unflatten(-1, (HALF**2, -1)).float()

    def read(self, features: torch.Tensor) -> HeatMaps:
        """Landmarks of fine features."""
        logits = self.heat(features).float().contiguous()
        with torch.autocast(logits.device.type, enabled=False):
            highest = logits.detach().amax((2, 3), keepdim=True)
            masses = torch.exp(logits - highest)
            moments = _moments(masses)
            total = moments[:, :, 0, 0]
            mean = torch.stack([moments[:, :, 0, 1], moments[:, :, 1, 0]], -1) / total[..., None]
            seen = (masses.flatten(2) / total[..., None]).detach()
            looked = seen.to(features.dtype) @ features.flatten(2).mT
            about = torch.einsum("blc,lck->blk", looked.float(), self.about) + self.about_bias
            covariance = _calibrated(_spread(moments.detach(), mean.detach()), about)
        return HeatMaps(logits, mean, total.log() + highest[:, :, 0, 0], covariance, about[..., 2])


def detector_of(network: DetectorNetwork, size: int, recipe: Any = None) -> Detector:
    """The Detector that uses the weights of a network, in half precision. size, recipe: see Detector."""
    return Detector(DetectorWeights(network_weights(network), network.size), size, recipe=recipe)


def network_of(detector: Detector) -> DetectorNetwork:
    """The network whose weights a Detector uses, which learns no more."""
    build = partial(DetectorNetwork, detector.weights.size, LANDMARKS, len(Region), None)
    network = load_network(build, detector.weights.arrays)
    return network.eval().requires_grad_(False)


def _moments(masses: torch.Tensor) -> torch.Tensor:
    """Sums (B, L, 3, 3) of masses (B, L, h, w) times powers 0 to 2 of y and of x, in cells."""
    height, width = masses.shape[2:]
    x = torch.arange(width, dtype=masses.dtype, device=masses.device)
    y = torch.arange(height, dtype=masses.dtype, device=masses.device)
    rows = masses.view(-1, height, width) @ torch.stack([x**0, x, x**2], 1)
    return (torch.stack([y**0, y, y**2]) @ rows).view(*masses.shape[:2], 3, 3)


def _spread(moments: torch.Tensor, mean: torch.Tensor) -> torch.Tensor:
    """Covariance (B, L, 2, 2) of heat maps with moments (B, L, 3, 3), powers of y and of x, and means (B, L, 2)."""
    total = moments[:, :, 0, 0]
    xx = moments[:, :, 0, 2] / total - mean[..., 0] ** 2
    yy = moments[:, :, 2, 0] / total - mean[..., 1] ** 2
    xy = moments[:, :, 1, 1] / total - mean[..., 0] * mean[..., 1]
    return torch.stack([torch.stack([xx, xy], -1), torch.stack([xy, yy], -1)], -2)


def _calibrated(spread: torch.Tensor, about: torch.Tensor) -> torch.Tensor:
    """exp(a) times a spread (B, L, 2, 2), plus exp(b) times the identity; a and b are the first two of about (B, L, 3).

    A heat map that is trained on blurred places is wider than the doubt, and one that is never wrong by more than a
    cell says nothing of what is below one.
    """
    factor = torch.exp(about[..., 0].clamp(-6, 3))[..., None, None]
    floor = torch.exp(about[..., 1].clamp(-6, 6))[..., None, None]
    return factor * spread + floor * torch.eye(2, device=spread.device)


def _start(network: DetectorNetwork, generator: torch.Generator | None) -> None:
    """Draw the initial weights."""
    start_convolutions(network, generator)
    if generator is None:
        return
    last = (network.face, network.heat, network.regions, network.edges)
    for layer in last:
        nn.init.normal_(layer.weight, std=1e-2, generator=generator)
    assert last[0].bias is not None
    nn.init.constant_(last[0].bias[:1].data, _RARE)
    nn.init.normal_(network.about, std=1e-2, generator=generator)
    nn.init.constant_(network.about_bias[:, :2].data, -2.0)
