"""A gesture network, trained on strokes of generated hands."""

from dataclasses import dataclass
from functools import partial

import numpy as np
import torch
from torch.nn import functional

from caricli.methods.train.gesture_hand import draw_gesture, draw_other
from caricli.methods.train.network_training import NetworkTraining
from caricli.methods.train.processes import ALL, Share
from caricli.models.gesture.config import GestureConfig
from caricli.models.gesture.model import GestureModel
from caricli.models.gesture.networks import GestureNetwork
from caricli.render.pixels.draw_stroke import draw_stroke
from caricli.seeds import TrainingSeed
from caricli.structures.gesture import GESTURES


@dataclass(frozen=True, eq=False)
class StrokeBatch:
    """Strokes of a step: ink (B, 1, S, S) from 0 to 1, and what they are, chances (B, 10) of GESTURES."""

    ink: torch.Tensor
    chances: torch.Tensor


class GestureTraining(NetworkTraining):
    """Training of a GestureNetwork, as every NetworkTraining, by cross entropy (sketch paper, section 5.2).

    Every stroke is drawn anew. What is no gesture is to be taken for each with the same chance, so that it stays below
    what a gesture needs. Errors are mean chances, 0 to 1, that strokes get of being what they are not.
    """

    def __init__(self, config: GestureConfig, share: Share = ALL) -> None:
        """config: GestureConfig. share: of this process."""
        make = partial(GestureNetwork, config.size, config.stride, len(GESTURES))
        super().__init__(make, config, share)
        self.unseen = {
            name: [
                draw_gesture(name, np.random.default_rng([config.seed, TrainingSeed.VALIDATION, number, row]))
                for row in range(config.validation)
            ]
            for number, name in enumerate(GESTURES)
        }

    def _draw(self, step: int) -> StrokeBatch:
        """This process's strokes of a step."""
        config = self.config
        ink = []
        chances = []
        for row in self.share.rows(config.batch):
            generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step, row])
            if generator.random() < config.others:
                stroke = draw_other(generator)
                chances.append(np.full(len(GESTURES), 1 / len(GESTURES)))
            else:
                number = int(generator.integers(len(GESTURES)))
                stroke = draw_gesture(GESTURES[number], generator)
                chances.append(np.eye(len(GESTURES))[number])
            ink.append(draw_stroke(stroke, config.size))
        pictures = torch.from_numpy(np.stack(ink)[:, None]).float() / 255
        return StrokeBatch(pictures, torch.from_numpy(np.stack(chances)).float())

    def _loss(self, drawn: StrokeBatch) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of strokes, and the chance that gestures get of being others."""
        with torch.autocast("cpu", torch.bfloat16, enabled=self.config.precision == "bfloat16"):
            logits = self.network(drawn.ink).float()
        certain = drawn.chances.amax(1) == 1
        right = (logits.detach().softmax(1) * drawn.chances).sum(1)
        error = 1 - (right * certain).sum() / certain.sum().clamp(min=1)
        return functional.cross_entropy(logits, drawn.chances), error

    def _validate(self) -> float:
        """Mean chance that further strokes get of being what they are not."""
        model = GestureModel(self.copied_average())
        right = [model.probabilities(strokes)[:, GESTURES.index(name)] for name, strokes in self.unseen.items()]
        return float(1 - np.mean(right))
