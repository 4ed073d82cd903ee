"""What a detector is asked for in its training: faces, landmarks with their doubt, and regions."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch.nn import functional

from caricli.methods.train.detector.split_pictures import SEEN
from caricli.methods.train.detector.windows import LARGEST, SMALLEST
from caricli.models.detector.config import COARSE, FINE, HALF, REACH, DetectorConfig
from caricli.models.detector.networks import FaceGrid, HeatMaps
from caricli.structures.detection import FaceFrame, MarkedPicture
from caricli.structures.parsing import BEYOND, Region

HEAT = 1.1
"""Deviation of the blob that stands for a landmark, cells."""

TAILS = 4.0
"""Degrees of freedom of the errors of landmarks: few are large (Student's t)."""

_BLOB = 0.15
"""Deviation of the blob that stands for a face on the grid, of its side."""

_NEAR = 0.4
"""Height of the blob from which on a cell must tell where the face is."""

_SMALL_REGIONS = 2.0
"""Weight of a pixel of a region that is small, beside other pixels."""

_REGION_WEIGHTS = [
    1.0 if region in (Region.BACKGROUND, Region.SKIN, Region.HAIR, Region.CLOTH, Region.OTHER) else _SMALL_REGIONS
    for region in Region
]


@dataclass(frozen=True, eq=False)
class FaceTargets:
    """What the grid should show, of B windows, as arrays or tensors.

    heat: (B, h, w) 1 at the cell of a face, less around it. counts: (B, h, w) bool where it is known whether there is
    one. values: (B, 5, h, w) shift, size and turn as in FaceGrid. near: (B, h, w) bool where these count.
    """

    heat: Any
    counts: Any
    values: Any
    near: Any

    @property
    def parts(self) -> tuple[Any, Any, Any, Any]:
        """All four."""
        return self.heat, self.counts, self.values, self.near

    @staticmethod
    def of(windows: Sequence[MarkedPicture], size: int) -> "FaceTargets":
        """The targets of windows of (size, size) pixels; faces of which little is seen may be found or not."""
        cells = size // COARSE
        shape = (len(windows), cells, cells)
        targets = FaceTargets(
            np.zeros(shape, np.float32),
            np.ones(shape, bool),
            np.zeros((shape[0], 5, cells, cells), np.float32),
            np.zeros(shape, bool),
        )
        for number, window in enumerate(windows):
            for points, visible in zip(window.landmarks, window.visible, strict=True):
                targets._add(number, FaceFrame.of(points), size, bool(visible.mean() >= SEEN))
        return targets

    def _add(self, number: int, frame: FaceFrame, size: int, seen: bool) -> None:
        """Put a face into the targets of a window. seen: whether enough of it is."""
        place = (frame.centre + 0.5) / COARSE - 0.5
        cell = np.rint(place).astype(int)
        inside = bool(((cell >= 0) & (cell < self.heat.shape[1])).all())
        rows = np.arange(self.heat.shape[1])
        squares = (rows[None, :] - place[0]) ** 2 + (rows[:, None] - place[1]) ** 2
        side = frame.side / COARSE
        unit = size / 128
        if not seen or not inside or not 0.9 * SMALLEST * unit <= frame.side <= 1.2 * LARGEST * unit:
            self.counts[number] &= squares > max(1.0, side / 2) ** 2
            return
        heat = np.exp(-squares / (2 * max(0.5, _BLOB * side) ** 2)).astype(np.float32)
        heat[cell[1], cell[0]] = 1
        mine = heat > self.heat[number]
        self.heat[number] = np.maximum(heat, self.heat[number])
        near = mine & (heat > _NEAR)
        self.near[number] |= near
        own = self.values[number]
        own[0][near] = np.broadcast_to(place[0] - rows[None, :], near.shape)[near]
        own[1][near] = np.broadcast_to(place[1] - rows[:, None], near.shape)[near]
        own[2][near] = np.log2(frame.side / REACH)
        own[3][near] = np.cos(frame.roll)
        own[4][near] = np.sin(frame.roll)


def face_loss(grid: FaceGrid, targets: FaceTargets) -> torch.Tensor:
    """Focal loss of where faces are (Zhou et al. 2019, equation 1), and smooth distances of what is said of them."""
    heat, counts, values, near = map(torch.as_tensor, targets.parts)
    chance = torch.sigmoid(grid.score)
    is_face = heat == 1
    misses = -((1 - chance) ** 2) * functional.logsigmoid(grid.score)
    alarms = -((1 - heat) ** 4) * chance**2 * functional.logsigmoid(-grid.score)
    looked_for = torch.where(is_face, misses, alarms)[counts | is_face].sum() / is_face.sum().clamp_min(1)
    told = torch.cat([grid.shift, grid.size[:, None], grid.turn], 1)
    apart = functional.smooth_l1_loss(told, values, beta=0.1, reduction="none").sum(1)
    return looked_for + (apart * near).sum() / near.sum().clamp_min(1)


def landmark_loss(
    maps: HeatMaps, points: torch.Tensor, visible: torch.Tensor, size: int, config: DetectorConfig
) -> tuple[torch.Tensor, torch.Tensor]:
    """Losses of places, doubts and visibility.

    points: (B, L, 2) pixels of the window. visible: (B, L) bool. size: of the window.
    Returns the weighted sum, and the mean distance of visible landmarks as a share of the window's side.

    Of each landmark within the window: the cross entropy of its heat map with a blob, the smooth distance of the mean,
    in percent of the window, the negative logarithm of Student's t with the covariance, and the cross entropy of
    whether it is visible, which counts outside, too.
    """
    within = ((points > -0.5) & (points < size - 0.5)).all(-1)
    weights = within / within.sum().clamp_min(1)
    places = (points + 0.5) / FINE - 0.5
    entropy = maps.log_sum - _blob_logits(maps.logits, places)
    distance = functional.smooth_l1_loss(maps.mean, places, reduction="none", beta=0.3).sum(-1)
    share = 100 * FINE / size
    seen = functional.binary_cross_entropy_with_logits(maps.visible, visible.float())
    loss = (weights * (config.heat_weight * entropy + config.place_weight * share * distance)).sum()
    loss = loss + config.doubt_weight * (weights * _doubt(maps, places)).sum() + config.visible_weight * seen
    clear = within & visible
    lengths = (maps.mean.detach() - places).norm(dim=-1) * FINE / size
    return loss, (lengths * clear).sum() / clear.sum().clamp_min(1)


def region_loss(logits: torch.Tensor, regions: torch.Tensor) -> torch.Tensor:
    """Cross entropy of regions, those of small regions counting more, and how little they overlap with the truth.

    logits: (B, h, w, 4, R) as ``DetectorNetwork.parse`` gives them. regions: (B, 2 h, 2 w) uint8.

    The latter is one minus the Dice coefficient of what all windows together show of a region, meaned over those that
    are there (Milletari et al. 2016, equation 1, with sizes in the place of their squares): to it a hat in a few of the
    windows is worth as much as the background of all.
    """
    step = FINE // HALF
    cells = regions.unflatten(2, (-1, step)).unflatten(1, (-1, step)).transpose(2, 3)
    truth = cells.flatten().long()
    weights = torch.tensor(_REGION_WEIGHTS, device=logits.device)
    likely = functional.log_softmax(logits.reshape(-1, len(Region)), -1)
    entropy = functional.nll_loss(likely, truth, weights, ignore_index=BEYOND)
    return entropy + _apart(likely, truth)


def _apart(likely: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """One minus the mean Dice coefficient of regions. likely: (N, R) logarithms. truth: (N,), BEYOND where not told."""
    told = truth != BEYOND
    chances = torch.exp(likely) * told[:, None]
    # A sum over all, because on a GPU one by indices is another each time.
    own = truth[:, None] == torch.arange(likely.shape[1], device=likely.device)
    common = torch.where(own, chances, 0).sum(0)
    pixels = own.sum(0)
    there = pixels > 0
    shares = 2 * common / (chances.sum(0) + pixels).clamp_min(1)
    return 1 - (shares * there).sum() / there.sum().clamp_min(1)


def _blob_logits(logits: torch.Tensor, places: torch.Tensor) -> torch.Tensor:
    """(B, L) means of logits (B, L, h, w) over Gaussian blobs around places (B, L, 2) in cells."""
    sides = (logits.shape[3], logits.shape[2])
    blobs = []
    for axis, side in enumerate(sides):
        apart = torch.arange(side, device=logits.device) - places[..., axis, None]
        blobs.append(functional.softmax(-(apart**2) / (2 * HEAT**2), -1))
    return (blobs[1][..., None, :] @ logits @ blobs[0][..., None])[..., 0, 0]


def _doubt(maps: HeatMaps, places: torch.Tensor) -> torch.Tensor:
    """(B, L) negative logarithm of the density of Student's t at the true places, up to a constant."""
    errors = places - maps.mean.detach()
    xx = maps.covariance[..., 0, 0]
    yy = maps.covariance[..., 1, 1]
    xy = maps.covariance[..., 0, 1]
    area = (xx * yy - xy**2).clamp_min(1e-8)
    x = errors[..., 0]
    y = errors[..., 1]
    square = (yy * x**2 - 2 * xy * x * y + xx * y**2) / area
    return 0.5 * area.log() + (TAILS + 2) / 2 * torch.log1p(square / TAILS)
