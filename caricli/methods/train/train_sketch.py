"""A network that sees faces in sketches, trained on sketches that are drawn as they are needed."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import torch

from caricli.data.dataset import Dataset
from caricli.errors import InputError
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.train.network_training import NetworkTraining
from caricli.methods.train.sketch_faces import SketchFaces
from caricli.methods.train.sketch_hand import Missing, SketchBatch, SketchHand
from caricli.methods.train.train_autodecoder import ALL, Share
from caricli.models.bilinear.model import BilinearModel
from caricli.models.linear_model import LinearModel
from caricli.models.sketch.config import SketchConfig, SketchSize
from caricli.models.sketch.networks import CAMERA, SketchNetwork
from caricli.models.sketch.window import POINTS
from caricli.seeds import TrainingSeed
from caricli.template.feature_curves import FeatureCurve, feature_curves

_FIRST = 512
"""Sketches from which it is told where points usually are, and how far cameras are from each other."""

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
        self.curves = named_curves(model)
        self.faces = SketchFaces.of(datasets, model, config.held, config.seed)
        self.unseen = _unseen(datasets, config.validation)
        self.hand = SketchHand(self.curves, config.size)
        super().__init__(partial(new_network, config, len(self.curves), len(model.basis)), config, share)
        self._basis = torch.from_numpy(model.basis.reshape(len(model.basis), -1)).float()
        self._drawn_basis = model.basis[:, self.hand.ids]
        self._settle()

    def _settle(self) -> None:
        """Tell the networks what is usual."""
        generator = np.random.default_rng([self.config.seed, TrainingSeed.START])
        latents = self.faces.draw(_FIRST, generator, self.config.mixed, self.config.people)
        drawn = self.hand.draw(self._positions(latents), np.full(_FIRST, self.config.strength), Missing(), generator)
        batch = self.hand.batch(drawn)
        dimension = latents.shape[1]
        for network in (self.network, self.average):
            network.usual.copy_(torch.from_numpy(batch.points.mean(0)))
            network.spread.copy_(torch.from_numpy(np.asarray(batch.points.std(0).mean())))
            network.start[dimension:] = torch.from_numpy(batch.cameras.mean(0))
            network.step[dimension:] = torch.from_numpy(np.maximum(batch.cameras.std(0), 1e-3))
            network.start[:dimension] = torch.from_numpy(latents.mean(0))
            network.step[:dimension] = torch.from_numpy(latents.std(0))

    def _positions(self, latents: np.ndarray) -> np.ndarray:
        return self.model.mean[self.hand.ids] + np.tensordot(latents, self._drawn_basis, 1)

    def _draw(self, step: int) -> tuple[SketchBatch, np.ndarray]:
        """This process's sketches of a step, and their latents."""
        config = self.config
        generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step])
        latents = self.faces.draw(config.batch, generator, config.mixed, config.people)
        missing = Missing(config.missing, None, config.unnamed)
        strength = config.strength * generator.uniform(0, 2, config.batch)
        drawn = self.hand.draw(self._positions(latents), strength, missing, generator)
        rows = slice(self.share.process, None, self.share.count)
        return self.hand.batch(drawn, rows), latents[rows]

    def _loss(self, drawn: tuple[SketchBatch, np.ndarray]) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of sketches, and the mean distance of vertices, metres."""
        batch, latents = drawn
        numbers = self._see(self.network, batch, self.config.precision == "bfloat16")
        gaps = (numbers[:, :-CAMERA] - torch.from_numpy(latents).float()) @ self._basis
        distance = gaps.unflatten(1, (-1, 3)).square().sum(-1).add(1e-12).sqrt().mean()
        away = (numbers[:, -CAMERA:] - torch.from_numpy(batch.cameras).float()) / self.network.step[-CAMERA:]
        loss = 100 * distance / self.model.template.height + self.config.camera_weight * away.square().mean()
        return loss, distance.detach()

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


def named_curves(model: LinearModel | BilinearModel) -> tuple[FeatureCurve, ...]:
    """The curves of a model's head. Raises InputError where its annotation names none."""
    curves = feature_curves(model.template.annotation)
    if not curves:
        raise InputError("expected a model whose annotation names the curves that a sketch shows, found none")
    return curves


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
