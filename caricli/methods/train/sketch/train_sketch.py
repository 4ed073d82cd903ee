"""A network that sees faces in sketches, trained on sketches that are drawn as they are needed."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import torch
from torch.nn import functional

from caricli.data.dataset import Dataset
from caricli.errors import InputError
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.train.network_training import NetworkTraining
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.sketch.sketch_faces import SketchFaces
from caricli.methods.train.sketch.sketch_hand import DrawnLines, Missing, SketchBatch, SketchHand
from caricli.models.linear_model import LinearModel
from caricli.models.sketch.config import SketchConfig, SketchSize
from caricli.models.sketch.networks import CAMERA, SketchNetwork
from caricli.models.sketch.window import POINTS
from caricli.seeds import TrainingSeed
from caricli.template.feature_curves import named_curves

_FIRST = 32
"""Batches of sketches from which it is told where points usually are and what they tell linearly."""

_EVERY = 8
"""One of so many vertices counts in the loss: their mean distance is nearly that of all."""

_BATCH = 64
"""Sketches that are validated at once."""


class SketchTraining(NetworkTraining):
    """Training of a SketchNetwork, as every NetworkTraining.

    The loss is the mean distance of the vertices from the nearest face that the shape model can make, in percent of the
    head's height, and the camera's squared error. Errors are mean distances of vertices in metres, in validation from
    the true ones.
    """

    def __init__(
        self, datasets: Sequence[Dataset], model: LinearModel, config: SketchConfig, share: Share = ALL
    ) -> None:
        """datasets: of the model's topology; people of their validation splits are validated with.

        Raises InputError when nobody is there to train or to validate with, or the head has no curves.
        """
        self.model = model
        self.curves = named_curves(model.template.annotation)
        self.faces = SketchFaces.of(datasets, model, config.held, config.seed)
        self.unseen = _unseen(datasets, config.validation)
        self.hand = SketchHand(self.curves, config.size)
        super().__init__(partial(new_network, config, len(self.curves), len(model.basis)), config, share)
        self._basis = torch.from_numpy(model.basis[:, ::_EVERY].reshape(len(model.basis), -1)).float()
        self._drawn_basis = model.basis[:, self.hand.ids]
        self._settle()

    def _settle(self) -> None:
        """Tell the networks what is usual, and let them begin with what lines tell linearly."""
        config = self.config
        generator = np.random.default_rng([config.seed, TrainingSeed.START])
        drawn, latents = self._drawn(_FIRST * config.batch, Missing(config.missing), generator)
        batch = self.hand.batch(replace(drawn, there=np.ones_like(drawn.there)), pictures=False)
        points = torch.from_numpy(batch.points)
        everything = torch.ones(points.shape[:2], dtype=torch.bool)
        for network in (self.network, self.average):
            network.lines.learn(batch.points, drawn.there)
            placed, scale, shift = network.lines.placed(points, everything)
            cameras = batch.cameras.copy()
            cameras[:, 3] += scale.log().numpy()
            cameras[:, 4:] = scale[:, None].numpy() * cameras[:, 4:] + shift.numpy()
            targets = torch.from_numpy(np.concatenate([latents, cameras], 1)).float()
            network.start.copy_(targets.mean(0))
            network.step.copy_(targets.std(0).clamp_min(1e-3))
            network.learn_plainly(network.lines(placed, everything)[0], targets)

    def _positions(self, latents: np.ndarray) -> np.ndarray:
        return self.model.mean[self.hand.ids] + np.tensordot(latents, self._drawn_basis, 1)

    def _draw(self, step: int) -> tuple[SketchBatch, np.ndarray]:
        """This process's sketches of a step, and their latents."""
        config = self.config
        generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step])
        missing = Missing(config.missing, None, config.unnamed)
        drawn, latents = self._drawn(config.batch, missing, generator)
        rows = slice(self.share.process, None, self.share.count)
        return self.hand.batch(drawn, rows, nameless=True), latents[rows]

    def _drawn(self, count: int, missing: Missing, generator: np.random.Generator) -> tuple[DrawnLines, np.ndarray]:
        """Random sketches, and their latents."""
        config = self.config
        latents = self.faces.draw(count, generator, config.mixed, config.people)
        strength = config.strength * generator.uniform(0, 2, count)
        return self.hand.draw(self._positions(latents), strength, missing, generator), latents

    def _loss(self, drawn: tuple[SketchBatch, np.ndarray]) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of sketches, and the mean distance of vertices, metres."""
        batch, latents = drawn
        numbers = self._see(self.network, batch, self.config.precision == "bfloat16")
        gaps = (numbers[:, :-CAMERA] - torch.from_numpy(latents).float()) @ self._basis
        distance = gaps.unflatten(1, (-1, 3)).square().sum(-1).add(1e-12).sqrt().mean()
        away = (numbers[:, -CAMERA:] - torch.from_numpy(batch.cameras).float()) / self.network.step[-CAMERA:]
        # Of few strokes nothing tells where the head is: what is far off counts less than its square.
        camera = functional.huber_loss(away, torch.zeros_like(away))
        return 100 * distance / self.model.template.height + self.config.camera_weight * camera, distance.detach()

    @torch.no_grad()
    def _validate(self) -> float:
        """Mean distance of the average's vertices from those of unseen people, sketches drawn as in the training."""
        self.average.eval()
        errors = []
        for start in range(0, len(self.unseen), _BATCH):
            vertices = self.unseen[start : start + _BATCH].astype(float)
            generator = np.random.default_rng([self.config.seed, TrainingSeed.VALIDATION, start])
            missing = Missing(self.config.missing)
            strength = np.full(len(vertices), self.config.strength)
            drawn = self.hand.draw(vertices[:, self.hand.ids], strength, missing, generator)
            numbers = self._see(self.average, self.hand.batch(drawn), False).double().numpy()
            away = self.model.decode(numbers[:, :-CAMERA]) - vertices
            errors.append(np.linalg.norm(away, axis=-1).mean(1))
        return float(np.concatenate(errors).mean())

    def _see(self, network: SketchNetwork, batch: SketchBatch, half: bool) -> torch.Tensor:
        windows = torch.from_numpy(batch.windows)[:, None].float() / 255
        with torch.autocast("cpu", torch.bfloat16, enabled=half):
            return network(windows, torch.from_numpy(batch.points)).float()


def new_network(config: SketchConfig, curves: int, dimension: int, generator: torch.Generator) -> SketchNetwork:
    """A network with random weights."""
    size = config.network()
    assert isinstance(size, SketchSize)
    return SketchNetwork(size, curves, POINTS, dimension, generator)


def _unseen(datasets: Sequence[Dataset], count: int) -> np.ndarray:
    share = -(-count // len(datasets))
    parts = [data.vertices[spread_rows(data.rows("validation"), share)] for data in datasets]
    vertices = np.concatenate(parts)
    if not len(vertices):
        raise InputError("expected a dataset with people of the validation split, found none")
    return vertices
