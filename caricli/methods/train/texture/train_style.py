"""A style network, trained on generated faces in generated media and on drawings."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
import torch
from torch.func import functional_call
from torch.nn import functional

from caricli.methods.dynamic.media import NAMES
from caricli.methods.train.network_training import NetworkTraining
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.texture.painted_pairs import PaintedPairs
from caricli.models.style.config import StyleConfig
from caricli.models.style.model import StyleModel
from caricli.models.style.networks import StyleNetwork, renormalised, statistics
from caricli.seeds import TrainingSeed

ENLARGED = 1.25
REDUCED = 0.7
"""How much larger or smaller than in a texture strokes are in windows."""

NEIGHBOURHOOD = 9
"""Side, pixels, of what ``local_statistics`` are of, and"""
APART = 4
"""how far apart."""

UNNAMED = -100
"""In the place of the number of a medium: nobody knows it."""


@dataclass(frozen=True, eq=False)
class StyleWindows:
    """What a step is on: B windows.

    content, style, truth: (B, 3, S, S) from 0 to 1; truth is what the content is to look like where ``paired`` (B,) is
    1, and elsewhere anything. media: (B,) numbers of the style's media, or UNNAMED. noise: (B, 1, S, S).
    """

    content: torch.Tensor
    style: torch.Tensor
    truth: torch.Tensor
    paired: torch.Tensor
    media: torch.Tensor
    noise: torch.Tensor


class StyleTraining(NetworkTraining):
    """Training of a StyleNetwork, as every NetworkTraining.

    The decoder learns from means and deviations of features at all sizes, which are to be the style's, from features at
    quarter size, which are to stay those that were renormalised (Huang and Belongie 2017, equations 11 to 13); from
    pictures that are to be decoded as they are; and, of a half of the windows, from what the very medium makes of the
    content, by ``local_statistics``. The encoder learns from decoding pictures and from telling their media apart:
    that its features change with the style's strokes is what makes the other losses speak, and as they do not move it
    they cannot be lessened by its forgetting them.
    Errors are ``local_statistics`` of what is painted, off those of what the medium makes of it.
    """

    def __init__(
        self,
        pairs: PaintedPairs,
        unseen: PaintedPairs,
        drawings: Sequence[np.ndarray],
        config: StyleConfig,
        share: Share = ALL,
    ) -> None:
        """pairs: to train on; unseen: to validate with. drawings: pictures (H, W, 3) uint8 to take styles from, too."""
        super().__init__(partial(new_style_network, config), config, share)
        self.pairs = pairs
        self.unseen = unseen
        self.drawings = drawings

    def _draw(self, step: int) -> StyleWindows:
        """This process's windows of a step: the first half of all are paired."""
        config = self.config
        rows = []
        for row in self.share.rows(config.batch):
            generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step, row])
            noise = generator.normal(size=(1, config.size, config.size)).astype(np.float32)
            rows.append((*self._windows(row < config.batch // 2, generator), noise))
        *pictures, paired, media, grain = zip(*rows, strict=True)
        content, style, truth = (
            torch.from_numpy(np.stack(part)).permute(0, 3, 1, 2).float() / 255 for part in pictures
        )
        given = (torch.tensor(paired).float(), torch.tensor(media), torch.from_numpy(np.stack(grain)))
        return StyleWindows(content, style, truth, *given)

    def _windows(self, paired: bool, generator: np.random.Generator) -> tuple:
        """Content, style and truth (S, S, 3) uint8, whether they belong together, and the number of the medium."""
        pairs = self.pairs
        size = self.config.size
        number = int(generator.integers(len(pairs.plain)))
        content, truth = _cut([pairs.plain[number], pairs.painted[number]], size, generator)
        if not paired and self.drawings and generator.random() < 0.5:
            drawing = self.drawings[int(generator.integers(len(self.drawings)))]
            return content, _cut([drawing], size, generator)[0], truth, paired, UNNAMED
        other = number if paired else int(generator.integers(len(pairs.plain)))
        style = _cut([pairs.other[other]], size, generator)[0]
        return content, style, truth, paired, int(pairs.media[other])

    def _loss(self, drawn: StyleWindows) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of windows, and the error of those that are paired."""
        config = self.config
        network = self.network
        count = len(drawn.content)
        pictures = torch.cat([drawn.content, drawn.style])
        with torch.autocast("cpu", torch.bfloat16, enabled=config.precision == "bfloat16"):
            features = network.encoder(pictures)
            again = network.decoder([level[::2] for level in features], drawn.noise)
            media = network.tell([level[count:] for level in features])
            styles = [level[count:].detach() for level in features]
            wanted = [
                renormalised(level, statistics(level), statistics(style))
                for level, style in zip((level[:count].detach() for level in features), styles, strict=True)
            ]
            painted = network.decoder(wanted, drawn.noise)
            weights = {name: value.detach() for name, value in network.encoder.named_parameters()}
            seen = functional_call(network.encoder, weights, (painted,))
        off = local_distance(painted.float(), drawn.truth)
        error = (drawn.paired * off).sum() / drawn.paired.sum().clamp(min=1)
        loss = config.again_weight * (again.float() - pictures[::2]).abs().mean() + config.pair_weight * error
        loss = loss + config.style_weight * style_distance(seen, styles)
        loss = loss + config.content_weight * functional.mse_loss(seen[-1].float(), wanted[-1]) / wanted[-1].var()
        if (drawn.media != UNNAMED).any():
            told = functional.cross_entropy(media.float(), drawn.media, ignore_index=UNNAMED)
            loss = loss + config.medium_weight * told
        return loss, error.detach()

    def _validate(self) -> float:
        """Mean error of unseen faces."""
        model = StyleModel(self.copied_average(), NAMES)
        return float(np.mean([painted for painted, _ in style_errors(model, self.unseen)]))


def style_errors(model: StyleModel, pairs: PaintedPairs) -> list[tuple[float, float]]:
    """Of every pair how far what a model paints is from what the medium makes of it, and how far the plain face is."""
    errors = []
    for plain, painted, other in zip(pairs.plain, pairs.painted, pairs.other, strict=True):
        lent = model.lend(plain[None], model.look(other))
        pictures = torch.from_numpy(np.stack([lent[0], plain, painted])).permute(0, 3, 1, 2) / 255
        errors.append(
            (float(local_distance(pictures[:1], pictures[2:])), float(local_distance(pictures[1:2], pictures[2:])))
        )
    return errors


def new_style_network(config: StyleConfig, generator: torch.Generator) -> StyleNetwork:
    """A network with random weights, whose encoder stays as it is where the settings say so."""
    network = StyleNetwork(config.width, len(NAMES), generator)
    network.encoder.requires_grad_(config.encoder == "learnt")
    return network


def style_distance(features: Sequence[torch.Tensor], styles: Sequence[torch.Tensor]) -> torch.Tensor:
    """Squared differences of means and deviations of features at all sizes, of the mean variance of the styles'."""
    total = torch.zeros(())
    for values, wanted in zip(features, styles, strict=True):
        own = statistics(values)
        goal = statistics(wanted)
        unit = goal[1].square().mean()
        total = total + sum(functional.mse_loss(a, b) for a, b in zip(own, goal, strict=True)) / unit
    return total


def local_statistics(pictures: torch.Tensor) -> torch.Tensor:
    """(B, 10, h, w) of pictures (B, 3, H, W): means and deviations of colours and slopes in small neighbourhoods.

    Where strokes lie exactly does not matter to them, only how coarse, how strong and of which colour they are.
    """
    grey = pictures.mean(1, keepdim=True)
    across = functional.pad(grey[..., 1:] - grey[..., :-1], (0, 1))
    down = functional.pad(grey[..., 1:, :] - grey[..., :-1, :], (0, 0, 0, 1))
    values = torch.cat([pictures, across, down], 1)
    mean = functional.avg_pool2d(values, NEIGHBOURHOOD, APART)
    square = functional.avg_pool2d(values.square(), NEIGHBOURHOOD, APART)
    return torch.cat([mean, (square - mean.square()).clamp(min=0).add(1e-5).sqrt()], 1)


def local_distance(pictures: torch.Tensor, others: torch.Tensor) -> torch.Tensor:
    """(B,) mean absolute differences of the ``local_statistics`` of pictures (B, 3, H, W)."""
    return (local_statistics(pictures) - local_statistics(others)).abs().mean((1, 2, 3))


def _cut(pictures: Sequence[np.ndarray], size: int, generator: np.random.Generator) -> list[np.ndarray]:
    """The same square window of pictures of one size, in which it lies anywhere, mirrored or not."""
    height, width = pictures[0].shape[:2]
    side = max(2, round(min(size / generator.uniform(REDUCED, ENLARGED), height, width)))
    top = int(generator.integers(height - side + 1))
    left = int(generator.integers(width - side + 1))
    turn = slice(None, None, -1 if generator.random() < 0.5 else 1)
    windows = (picture[top : top + side, left : left + side][:, turn] for picture in pictures)
    method = cv2.INTER_AREA if side > size else cv2.INTER_LINEAR
    return [cv2.resize(np.ascontiguousarray(window), (size, size), interpolation=method) for window in windows]
