"""What each choice of the deformable model is worth (deformable paper, sections 3.3 and 4.2)."""

import time
from dataclasses import dataclass, replace

import numpy as np
import torch

from caricli.methods.train.train_autodecoder import AutoDecoderTraining, Surface
from caricli.models.ablation.networks import ConditionedSiren, VertexArray
from caricli.models.deformable.model import HyperSiren
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.pca.model import PcaModel

POSITIONS, DISPLACEMENTS, CONDITIONING = "vertex positions", "vertex displacements", "SIREN with conditioning"
HYPERNETWORK = "SIREN hypernetwork"
VERTICES_ONLY = f"{HYPERNETWORK}, vertices only"
NETWORKS = (POSITIONS, DISPLACEMENTS, CONDITIONING, HYPERNETWORK, VERTICES_ONLY)
LINEAR = {"PCA": PcaModel, "intrinsic": IntrinsicModel}
_CODE_RATE = 0.3
_SURFACE_POINTS = 20_000
_CODES, _BETWEEN = 4, 5


@dataclass(frozen=True)
class AblationRow:
    """One model. Errors are mean distances in percent of the head's height.

    train, test: at the vertices of training and of unseen meshes, the codes of the latter fitted to the end. surface:
    the same at uniform points of the unseen meshes' surfaces. seconds: of the training and its validations.
    curves: from train and test to epochs and errors during the training; None where there are no epochs.
    """

    name: str
    parameters: int
    train: float
    test: float
    surface: float
    seconds: float
    curves: dict | None = None


def evaluate_ablation(template, frame, shapes, unseen, config, device="cpu", report=lambda done, total: None):
    """Train all NETWORKS, then PCA and intrinsic of the same latent dimension, on the same meshes.

    template: Template. frame: Frame of the networks. shapes (N, V, 3), unseen (U, V, 3): metres. config:
    AblationConfig. report: called with the epochs done and their total.
    Yields an AblationRow each. Raises NumericsError when a loss is not finite.
    """
    surface = Surface(frame, template.faces, device)
    measure = _Measure(surface, shapes, unseen, template.height, config.seed)
    for k, name in enumerate(NETWORKS):
        settings = replace(config, vertex_share=1.0) if name == VERTICES_ONLY else config
        network = _network(name, template, settings).to(device)
        start, records = time.perf_counter(), []
        training = AutoDecoderTraining(network, surface, shapes, unseen, settings)
        for record in training.epochs():
            records.append(record)
            report(k * config.epochs + record.epoch, len(NETWORKS) * config.epochs)
        seconds = time.perf_counter() - start
        parameters = sum(parameter.numel() for parameter in network.requires_grad_(False).parameters())
        codes = fit_codes(training)
        network.precision = torch.float32  # as models decode
        errors = measure(_network_fields(network, training.latents), _network_fields(network, codes))
        yield AblationRow(name, parameters, *errors, seconds, _curves(records, template.height))
    for name, kind in LINEAR.items():
        start = time.perf_counter()
        model = kind.train(template, shapes, config.latent, config.seed)
        seconds = time.perf_counter() - start
        parameters = sum(tensor.size for tensor in model.tensors().values())
        errors = measure(_model_fields(model, surface, shapes), _model_fields(model, surface, unseen))
        yield AblationRow(name, parameters, *errors, seconds)


def _network(name, template, config):
    generator, precision = torch.Generator().manual_seed(config.seed), getattr(torch, config.precision)
    if name in (POSITIONS, DISPLACEMENTS):
        sizes = config.size(), config.array_hidden, len(template.vertices)
        return VertexArray(*sizes, config.latent_std, generator, positions=name == POSITIONS)
    if name == CONDITIONING:
        return ConditionedSiren(config.size(), config.latent_std, generator, precision)
    return HyperSiren(config.size(), generator, precision)


def _curves(records, height):
    errors = {
        "train": [(record.epoch, record.train_error) for record in records],
        "test": [(record.epoch, record.validation_error) for record in records if record.validation_error is not None],
    }
    return {split: [(epoch, 100 * error / height) for epoch, error in pairs] for split, pairs in errors.items()}


def _network_fields(network, codes):
    """A function from the number of a mesh and Points to the displacements of its code."""

    @torch.no_grad()
    def displace(number, points):
        return network(codes[number : number + 1], points)[0]

    return displace


def _model_fields(model, surface, shapes):
    """The same for the projections of shapes on a linear model."""

    def displace(number, points):
        shape = model.decode(model.encode(shapes[number].astype(np.float64)))
        return points.values(surface.displacements(shape))

    return displace


class _Measure:
    """Mean distances in percent of the head's height: training meshes, unseen ones, unseen ones between vertices."""

    def __init__(self, surface, shapes, unseen, height, seed):
        between = surface.draw(_SURFACE_POINTS, 0.0, np.random.default_rng([seed, _BETWEEN]))
        vertices = surface.at_vertices(np.arange(len(surface.vertices)))
        self.percent = 100 / (surface.frame.scale * height)
        shapes, unseen = surface.displacements(shapes), surface.displacements(unseen)
        self.tasks = (shapes, vertices), (unseen, vertices), (unseen, between)

    def __call__(self, known, new):
        """known, new: fields of the training and of the unseen meshes."""
        for displace, (fields, points) in zip((known, new, new), self.tasks, strict=True):
            gaps = (displace(k, points) - points.values(field) for k, field in enumerate(fields))
            yield self.percent * float(torch.stack([gap.norm(dim=-1).mean() for gap in gaps]).mean())


def fit_codes(training):
    """Codes (U, D) of a training's unseen meshes, fitted to their vertices (supplement 3).

    Minimises equation 1 over the codes by Adam, at vertices drawn anew every step, from the last validation's codes.
    """
    config, surface = training.config, training.surface
    codes = training.codes.detach().clone().requires_grad_()
    optimiser = torch.optim.Adam([codes], lr=_CODE_RATE * config.latent_std)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, config.code_steps)
    for step in range(config.code_steps):
        points = surface.draw(config.points, 1.0, np.random.default_rng([config.seed, _CODES, step]))
        squares = (training.network(codes, points) - points.values(training.unseen)).square().sum(-1)
        loss = config.data_weight * squares.mean() + config.latent_weight * codes.square().mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    return codes.detach()
