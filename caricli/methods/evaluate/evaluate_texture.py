"""Textures made for other expressions, beside the true ones (expressions paper, sections 4.2.2 and 4.3)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import torch

from caricli.methods.dynamic.shape_maps import CHANNELS
from caricli.methods.evaluate.ratio_interval import ratio_interval
from caricli.methods.train.stages import Report, unwatched
from caricli.methods.train.texture.texture_losses import TextureBatch
from caricli.methods.train.texture.texture_pairs import TexturePairs

KEPT = "kept"
"""The texture as it is: what every painter is measured against."""

ATTENTION = 0.3
"""Share of the face's texels, those that move most, where change is due."""

OPENED = 0.1
"""Gap between the lips, in quarters of the face's width, from which a mouth is open."""

SOURCE_GAP = CHANNELS.index("source_gap")
TARGET_GAP = CHANNELS.index("target_gap")

_BATCH = 16
TRUE = "true"
"""The textures that are to be painted."""

Judge = Callable[[TextureBatch, torch.Tensor], torch.Tensor]
"""A batch and textures (B, 3, S, S) of its sources with other expressions to the weights (B, 52) that are read."""

Painter = Callable[[TextureBatch], torch.Tensor]
"""A batch to textures (B, 3, S, S) of its targets."""


@dataclass(frozen=True)
class TextureChoice:
    """count: pairs. seed: of their choice."""

    count: int = 400
    seed: int = 0


@dataclass(frozen=True, eq=False)
class TextureTally:
    """Sums of differences from the true textures, by painter and region, and textured face.

    who: (P,) numbers of the people whose faces they are. sums: arrays (P,) by painter and region. counts: arrays (P,)
    of texels by region. read: by painter, and of the true textures, squared errors of the weights that a judge reads.
    """

    who: np.ndarray
    sums: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)
    counts: dict[str, np.ndarray] = field(default_factory=dict)
    read: dict[str, list[float]] = field(default_factory=dict)

    def add(self, batch: TextureBatch, mouth: np.ndarray, pictures: Mapping[str, torch.Tensor]) -> None:
        """Count what painters made of a batch. mouth: (S, S) bool. pictures: (B, 3, S, S) by painter."""
        rows = batch.people.numpy()
        for region, mask in regions(batch, torch.from_numpy(mouth)).items():
            self._sum(self.counts, region, rows, mask.sum((1, 2)))
            for painter, picture in pictures.items():
                away = (picture - batch.target).abs().mean(1)
                self._sum(self.sums.setdefault(painter, {}), region, rows, (away * mask).sum((1, 2)))

    def judge(self, batch: TextureBatch, judge: Judge, pictures: Mapping[str, torch.Tensor]) -> None:
        """Read the expressions of what painters made of a batch, and of the true textures."""
        for painter, picture in {**pictures, TRUE: batch.target}.items():
            away = (judge(batch, picture) - batch.target_code).square().mean(1)
            self.read.setdefault(painter, []).extend(away.tolist())

    @property
    def people(self) -> int:
        """How many people there are of whom something was painted."""
        painted = sum(self.counts.values(), np.zeros(len(self.who)))
        return len(np.unique(self.who[painted > 0]))

    @property
    def reading(self) -> dict[str, float]:
        """Root mean square error of the weights that are read, by painter, and of the true textures."""
        return {painter: float(np.sqrt(np.mean(values))) for painter, values in self.read.items()}

    def _sum(self, table: dict[str, np.ndarray], region: str, rows: np.ndarray, values: torch.Tensor) -> None:
        total = table.setdefault(region, np.zeros(len(self.who)))
        np.add.at(total, rows, values.double().numpy())

    def figures(self, seed: int = 0) -> dict[str, dict[str, dict[str, float | None]]]:
        """By painter and region: ``error``, mean difference of sRGB from 0 to 1; ``percent`` of that of the kept
        texture; and ``low`` and ``high`` of its ``ratio_interval``. All are None for a region that no face shows.

        seed: of the draws.
        """
        return {
            painter: {region: self._figure(painter, region, seed) for region in self.counts} for painter in self.sums
        }

    def _figure(self, painter: str, region: str, seed: int) -> dict[str, float | None]:
        own = self.sums[painter][region]
        texels = self.counts[region]
        shows = texels > 0
        if not shows.any():
            return dict.fromkeys(("error", "percent", "low", "high"))
        kept = self.sums[KEPT][region]
        percent, low, high = ratio_interval(100 * own[shows], kept[shows], self.who[shows], seed=seed)
        return {"error": float(own.sum() / texels.sum()), "percent": percent, "low": low, "high": high}


def regions(batch: TextureBatch, mouth: torch.Tensor) -> dict[str, torch.Tensor]:
    """Masks (B, S, S) of a batch's regions.

    attention: the texels of the skin that move most; outside: the rest of it; mouth: what is between the lips where the
    target opens them; opens: that of mouths that were closed. What a picture did not show does not count.

    mouth: (S, S) bool, where the chart has what is between the lips.
    """
    skin = batch.seen[:, 0] & ~mouth
    moved = torch.where(skin, batch.moved[:, 0], -1.0).flatten(1)
    count = (ATTENTION * skin.flatten(1).sum(1)).long()
    least = moved.sort(1, descending=True).values.gather(1, count[:, None])
    attention = skin & (moved > least).view_as(skin)
    gaps = torch.where(mouth, batch.forth[:, [SOURCE_GAP, TARGET_GAP]], 0)
    was_open, is_open = (gaps.flatten(2).amax(2) > OPENED).T[:, :, None, None]
    mouth = batch.seen[:, 0] & mouth & is_open
    return {"attention": attention, "outside": skin & ~attention, "mouth": mouth, "opens": mouth & ~was_open}


@torch.no_grad()
def evaluate_texture(
    painters: Mapping[str, Painter],
    judge: Judge,
    pairs: TexturePairs,
    settings: TextureChoice,
    report: Report = unwatched,
) -> TextureTally:
    """Let painters paint the same pairs of people, and measure them.

    painters: by name; the texture kept as it is joins them. judge: that reads expressions. pairs: of people of no
    training. settings: TextureChoice. report: called with pairs done and all.
    """
    tally = TextureTally(pairs.people.numbers)
    generator = np.random.default_rng(settings.seed)
    for start in range(0, settings.count, _BATCH):
        batch = pairs.draw(min(_BATCH, settings.count - start), generator, paired=True)
        pictures = {KEPT: batch.source} | {name: painter(batch) for name, painter in painters.items()}
        tally.add(batch, pairs.grid.mouth, pictures)
        tally.judge(batch, judge, pictures)
        report(min(start + _BATCH, settings.count), settings.count)
    return tally
