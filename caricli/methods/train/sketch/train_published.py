"""The published sketch networks, trained as published (sketch paper, section 4.4)."""

from collections.abc import Sequence
from enum import IntEnum
from functools import partial

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from caricli.data.dataset import Dataset
from caricli.methods.train.network_training import NetworkTraining
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.sketch.published_faces import (
    PublishedFaces,
    drawn_points,
    importance,
    point_space,
)
from caricli.methods.train.sketch.sketch_hand import Canvas, Missing, SketchBatch, SketchHand
from caricli.methods.train.stages import Report, unwatched
from caricli.models.bilinear.model import BilinearModel
from caricli.models.sketch.config import PublishedSize, SketchConfig
from caricli.models.sketch.networks import CAMERA
from caricli.models.sketch.published import PublishedNetwork, plain_linear
from caricli.models.sketch.window import POINTS
from caricli.seeds import TrainingSeed
from caricli.template.feature_curves import named_curves

_BATCH = 64
"""Sketches that are validated at once."""


class Step(IntEnum):
    """What is learnt: to tell people and expressions apart; u and v, convolutions as they are; the vertices."""

    CLASSIFY = 0
    REGRESS = 1
    TUNE = 2


class PublishedTraining(NetworkTraining):
    """Training of a PublishedNetwork in three steps, as every NetworkTraining.

    The loss of the last step is equation 2, in squares of percent of the head's height; errors are then root mean
    squares of the distances of vertices, metres, those of validation mean distances. In the first step the share of
    sketches taken for somebody else, times the height, stands in the place of the error.
    """

    def __init__(
        self,
        datasets: Sequence[Dataset],
        model: BilinearModel,
        config: SketchConfig,
        share: Share = ALL,
        report: Report = unwatched,
    ) -> None:
        """datasets: of the model's topology, the first a full grid. report: told of heads whose wrinkles are found.

        Raises InputError when nobody is there to train or to validate with, the head has no curves, or there is no
        grid.
        """
        self.model = model
        self.curves = named_curves(model.template.annotation)
        self.canvas = canvas_of(model)
        self.hand = SketchHand(self.curves, config.size, self.canvas)
        self.faces = PublishedFaces.of(datasets, model, self.hand, config, report)
        kinds = [int(numbers.max()) + 1 for numbers in (self.faces.person, self.faces.expression)]
        super().__init__(partial(new_published, config, model, len(self.curves), kinds), config, share)
        self.height = model.template.height
        weights = importance(model, self.hand, config.importance)
        flat = model.basis.reshape(len(model.basis), -1)
        self._core = torch.from_numpy(model.space.core.reshape(len(model.basis), -1)).float()
        self._products = torch.from_numpy((flat * np.repeat(weights, 3)) @ flat.T).float()
        self._settle(datasets[0])
        self._begin(Step.CLASSIFY)

    def _settle(self, grid: Dataset) -> None:
        """Tell the networks what is usual."""
        space = point_space(grid, self.hand, self.model)
        usual = drawn_points(self.model.decode(self.model.prior.mean)[None], self.hand)[0]
        canvas = self.canvas
        camera = np.concatenate([np.zeros(3), [np.log(canvas.scale)], -canvas.scale * canvas.centre])
        codes = self.faces.codes
        for network in (self.network, self.average):
            network.learn_points(space)
            network.usual.copy_(torch.from_numpy(usual))
            network.start.copy_(torch.from_numpy(np.concatenate([codes.mean(0), camera])))
            network.step.copy_(torch.from_numpy(np.concatenate([codes.std(0), np.ones(CAMERA)])))

    def step_of(self, epoch: int) -> Step:
        """What an epoch is for, from 0."""
        ends = np.cumsum([self.config.classify, self.config.regress])
        return Step(int((epoch >= ends).sum()))

    @property
    def validates(self) -> bool:
        """See NetworkTraining."""
        return self.step_of(self.epoch - 1) is Step.TUNE

    def copied_average(self) -> PublishedNetwork:
        """See NetworkTraining; without what tells people apart."""
        network = super().copied_average()
        network.kinds = nn.ModuleList()
        return network

    def load_state(self, state: dict) -> None:
        """See NetworkTraining."""
        counters = state.get("counters")
        epoch = counters[0] if isinstance(counters, list) and counters and isinstance(counters[0], int) else 0
        self._begin(self.step_of(max(epoch - 1, 0)))
        super().load_state(state)

    def _begin(self, step: Step) -> None:
        """Learn what a step is for."""
        network = self.network
        network.fixed = step is Step.REGRESS
        left = network.last if step is Step.CLASSIFY else network.kinds
        idle = {id(parameter) for parameter in left.parameters()}
        if network.fixed and network.variant.pixels:
            idle |= {id(parameter) for parameter in network.convolutions.parameters()}
        for parameter in network.parameters():
            parameter.requires_grad_(id(parameter) not in idle)
        self._optimise()
        self.step = step

    def _kernels(self) -> Sequence[torch.Tensor]:
        kernels = self.network.kernels() if self.config.kernel_rate else []
        return [kernel for kernel in kernels if kernel.requires_grad]

    def _train_epoch(self) -> tuple[float, float]:
        step = self.step_of(self.epoch)
        if step is not self.step:
            self._begin(step)
        return super()._train_epoch()

    def _set_rate(self, step: int) -> None:
        """Every step of the training has its own schedule."""
        config = self.config
        ends = [0, config.classify, config.classify + config.regress, config.epochs]
        first, last = (end * config.steps for end in ends[self.step : self.step + 2])
        self._schedule(step - first, last - first, config.learning_rate * (config.later_rate if self.step else 1))

    def _draw(self, step: int) -> tuple[SketchBatch, np.ndarray, np.ndarray]:
        """This process's sketches of a step, their shape-level input, and the numbers of their faces."""
        config = self.config
        generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step])
        faces = self.faces
        count = len(faces.person) if self.step is Step.CLASSIFY else len(faces.codes)
        numbers = generator.integers(count, size=config.batch)
        missing = Missing(config.missing, None, config.unnamed)
        strength = config.strength * generator.uniform(0, 2, config.batch)
        wrinkles = None if faces.book is None else faces.book.of_rows(numbers)
        drawn = self.hand.draw(faces.positions[numbers].astype(float), strength, missing, generator, wrinkles)
        rows = slice(self.share.process, None, self.share.count)
        batch = self.hand.batch(drawn, rows, self.network.variant.pixels)
        return batch, self.average.coefficients(batch.points), numbers[rows]

    def _loss(self, drawn: tuple[SketchBatch, np.ndarray, np.ndarray]) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of sketches, and an error, metres."""
        batch, coefficients, numbers = drawn
        network = self.network
        windows = torch.from_numpy(batch.windows)[:, None].float() / 255
        with torch.autocast("cpu", torch.bfloat16, enabled=self.config.precision == "bfloat16"):
            told = torch.from_numpy(coefficients)
            if self.step is Step.CLASSIFY:
                return self._classified(network.classes(windows, told), numbers)
            codes = network.tell(windows, told)[:, :-CAMERA].float()
        target = torch.from_numpy(self.faces.codes[numbers]).float()
        squared = self._squared(codes, torch.from_numpy(self.faces.rows[numbers]).float())
        error = squared.clamp_min(0).sqrt().mean().detach()
        if self.step is Step.REGRESS:
            return ((codes - target) / network.step[:-CAMERA]).square().mean(), error
        return (squared / (self.height / 100) ** 2).mean(), error

    def _classified(self, logits: list[torch.Tensor], numbers: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
        kinds = [torch.from_numpy(column[numbers]) for column in (self.faces.person, self.faces.expression)]
        losses = [functional.cross_entropy(own.float(), kind) for own, kind in zip(logits, kinds, strict=True)]
        wrong = (logits[0].argmax(1) != kinds[0]).float().mean()
        return torch.stack(losses).sum(), self.height * wrong.detach()

    def _squared(self, codes: torch.Tensor, rows: torch.Tensor) -> torch.Tensor:
        """(B,) mean over the vertices of their weighted squared distances, square metres."""
        identity = self.model.space.identity
        v = functional.pad(codes[:, identity:], (1, 0), value=1.0)
        both = (codes[:, :identity, None] * v[:, None]).flatten(1)
        gaps = both @ self._core.T - rows
        return ((gaps @ self._products) * gaps).sum(1) / len(self.model.template.vertices)

    @torch.no_grad()
    def _validate(self) -> float:
        """Mean distance of the average's vertices from those of faces that are not trained with, metres."""
        self.average.eval()
        errors = []
        for start in range(0, len(self.faces.unseen), _BATCH):
            vertices = self.faces.unseen[start : start + _BATCH].astype(float)
            generator = np.random.default_rng([self.config.seed, TrainingSeed.VALIDATION, start])
            book = self.faces.unseen_book
            wrinkles = None if book is None else book.of_rows(np.arange(start, start + len(vertices)))
            strength = np.full(len(vertices), self.config.strength)
            drawn = self.hand.draw(vertices[:, self.hand.ids], strength, Missing(), generator, wrinkles)
            batch = self.hand.batch(drawn)
            windows = torch.from_numpy(batch.windows)[:, None].float() / 255
            numbers = self.average(windows, torch.from_numpy(batch.points)).double().numpy()
            away = self.model.decode(numbers[:, :-CAMERA]) - vertices
            errors.append(np.linalg.norm(away, axis=-1).mean(1))
        return float(np.concatenate(errors).mean())


def canvas_of(model: BilinearModel) -> Canvas:
    """The canvas on which a model's heads are drawn for published networks."""
    return Canvas.of(model.decode(model.prior.mean), named_curves(model.template.annotation))


def new_published(
    config: SketchConfig, model: BilinearModel, curves: int, kinds: Sequence[int], generator: torch.Generator
) -> PublishedNetwork:
    """A network with random weights, and layers that tell kinds of people and of expressions apart."""
    size = config.network(model.space.identity, model.space.core.shape[2])
    assert isinstance(size, PublishedSize)
    network = PublishedNetwork(size, curves, POINTS, config.size, generator)
    network.kinds = nn.ModuleList(plain_linear(network.width, count) for count in kinds)
    return network
