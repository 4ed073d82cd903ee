"""What each choice of the deformable model is worth (deformable paper, sections 3.3 and 4.2)."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import torch

from caricli.data.dataset import Dataset
from caricli.methods.evaluate.evaluate_shape import split_rows
from caricli.methods.train.deformable.code_fit import CodeFit
from caricli.methods.train.deformable.surface import Points, Surface, TrainingMeshes
from caricli.methods.train.stages import EpochRecord, Report, unwatched
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.ablation.config import AblationConfig
from caricli.models.ablation.networks import ArraySize, ConditionedSiren, VertexArray
from caricli.models.deformable.model import UnitBox
from caricli.models.deformable.networks import HyperSiren
from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel
from caricli.models.shape_model import ShapeModel
from caricli.seeds import TrainingSeed
from caricli.template.template import Template

POSITIONS = "vertex positions"
DISPLACEMENTS = "vertex displacements"
CONDITIONING = "SIREN with conditioning"
HYPERNETWORK = "SIREN hypernetwork"
VERTICES_ONLY = f"{HYPERNETWORK}, vertices only"
NETWORKS = (POSITIONS, DISPLACEMENTS, CONDITIONING, HYPERNETWORK, VERTICES_ONLY)
LINEAR = ("PCA", "intrinsic")
DRAWN = (POSITIONS, DISPLACEMENTS, CONDITIONING, HYPERNETWORK)
"""Networks whose curves make the figure."""

CODE_RATE = 0.3
"""Learning rate of the final codes, in units of latent_std: it falls to nothing along a cosine."""

ERRORS = ("train", "test", "surface")
"""Of an AblationRow."""

SURFACE_POINTS = 20_000
"""Points between the vertices that errors are measured at: about as many as the paper draws."""

Fields = Callable[[int, Points], torch.Tensor]
"""From the number of a mesh and Points to displacements (n, 3)."""


@dataclass(frozen=True)
class AblationRow:
    """One model. Errors are mean distances in percent of the head's height.

    train, test: at the vertices of training and of unseen meshes, the codes of the latter fitted to the end. surface:
    the same at uniform points of the unseen meshes' surfaces. seconds: of the training and its validations.
    latent_weight: lambda_reg of equation 1, of networks.
    curves: from train and test to epochs and errors during the training; None where there are no epochs.
    """

    name: str
    parameters: int
    train: float
    test: float
    surface: float
    seconds: float
    latent_weight: float | None = None
    curves: dict[str, list[tuple[int, float]]] | None = None


@dataclass(frozen=True)
class AblationFigures:
    """One model over several seeds.

    mean: AblationRow of mean errors and seconds, with the curves of the first seed. spread: standard deviation of each
    of ERRORS, or None for one seed. by_seed: errors of every seed.
    """

    mean: AblationRow
    spread: dict[str, float] | None
    by_seed: dict[int, dict[str, float]]


def ablation_meshes(data: Dataset, points: np.ndarray, config: AblationConfig, device: str = "cpu") -> TrainingMeshes:
    """The meshes of a dataset that an ablation trains and measures on, as many as the settings say.

    points: (V, 3) metres, the shape that the networks deform.
    Raises InputError when a split has too few meshes.
    """
    shapes = data.vertices[split_rows(data, "train", 3, config.meshes)]
    unseen = data.vertices[split_rows(data, "test", 1, config.unseen)]
    return TrainingMeshes(Surface(UnitBox(points), data.template.faces, device), shapes, unseen)


def evaluate_ablation(
    template: Template, meshes: TrainingMeshes, config: AblationConfig, report: Report = unwatched
) -> Iterator[AblationRow]:
    """Train all NETWORKS, then PCA and intrinsic of the same latent dimension, on the same meshes.

    report: called with the epochs done and their total.
    Yields an AblationRow each. Raises NumericsError when a loss is not finite.
    """
    measure = _Measure(meshes, template.height, config.seed)
    for k, name in enumerate(NETWORKS):
        settings = replace(config, vertex_share=1.0) if name == VERTICES_ONLY else config
        network = _network(name, template, settings, meshes.surface)
        records = []
        start = time.perf_counter()
        training = AutoDecoderTraining(network, meshes, settings)
        for record in training.epochs():
            records.append(record)
            report(k * config.epochs + record.epoch, len(NETWORKS) * config.epochs)
        seconds = time.perf_counter() - start
        parameters = sum(parameter.numel() for parameter in network.requires_grad_(False).parameters())
        codes = fit_codes(training, config.code_steps)
        if isinstance(network, ConditionedSiren | HyperSiren):
            network.precision = torch.float32  # as models decode
        errors = measure(_network_fields(network, training.latents), _network_fields(network, codes))
        curves = _curves(records, template.height)
        yield AblationRow(name, parameters, *errors, seconds, config.latent_weight, curves)
    for name in LINEAR:
        start = time.perf_counter()
        model = _linear_model(name, template, meshes.shapes, config)
        seconds = time.perf_counter() - start
        parameters = sum(tensor.size for tensor in model.tensors().values())
        trained = _model_fields(model, meshes.surface, meshes.shapes)
        errors = measure(trained, _model_fields(model, meshes.surface, meshes.unseen))
        yield AblationRow(name, parameters, *errors, seconds)


def evaluate_seeds(
    template: Template,
    meshes: TrainingMeshes,
    config: AblationConfig,
    seeds: Sequence[int],
    report: Report = unwatched,
) -> list[AblationFigures]:
    """``evaluate_ablation`` for each of a few seeds, in the place of the settings' own.

    Returns AblationFigures of every model.
    """
    runs = []
    for k, seed in enumerate(seeds):
        own = partial(_report_seed, report, k, len(seeds))
        runs.append([*evaluate_ablation(template, meshes, replace(config, seed=seed), own)])
    return [_over_seeds(seeds, rows) for rows in zip(*runs, strict=True)]


def _report_seed(report: Report, number: int, seeds: int, done: int, total: int) -> None:
    report(number * total + done, seeds * total)


def _over_seeds(seeds: Sequence[int], rows: Sequence[AblationRow]) -> AblationFigures:
    errors = np.array([[getattr(row, name) for name in ERRORS] for row in rows])
    seconds = float(np.mean([row.seconds for row in rows]))
    means = _by_error(errors.mean(0))
    mean = replace(rows[0], train=means["train"], test=means["test"], surface=means["surface"], seconds=seconds)
    spread = _by_error(errors.std(0, ddof=1)) if len(rows) > 1 else None
    return AblationFigures(mean, spread, {seed: _by_error(own) for seed, own in zip(seeds, errors, strict=True)})


def _by_error(values: np.ndarray) -> dict[str, float]:
    return dict(zip(ERRORS, values.tolist(), strict=True))


def fit_codes(training: AutoDecoderTraining, steps: int) -> torch.Tensor:
    """Codes (U, D) of a training's unseen meshes, fitted to their vertices (supplement 3).

    Minimises equation 1 over the codes by Adam, at vertices drawn anew every step, from the last validation's codes.
    """
    config = training.config
    fit = CodeFit(training.codes, CODE_RATE, config)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(fit.optimiser, steps)
    for step in range(steps):
        generator = np.random.default_rng([config.seed, TrainingSeed.CODES, step])
        fit.step(training.network, training.surface.draw(config.points, 1.0, generator), training.unseen)
        schedule.step()
    return fit.codes.detach()


def _network(name: str, template: Template, config: AblationConfig, surface: Surface) -> torch.nn.Module:
    generator = torch.Generator().manual_seed(config.seed)
    precision = getattr(torch, config.precision)
    network: torch.nn.Module
    if name in (POSITIONS, DISPLACEMENTS):
        size = ArraySize(config.latent, config.array_hidden, len(template.vertices))
        network = VertexArray(size, config.latent_std, generator, positions=name == POSITIONS)
    elif name == CONDITIONING:
        network = ConditionedSiren(config.size(), config.latent_std, generator, precision)
    else:
        network = HyperSiren(config.size(), generator, precision)
    return network.to(surface.vertices.device)


def _linear_model(name: str, template: Template, shapes: np.ndarray, config: AblationConfig) -> ShapeModel:
    if name == "PCA":
        return PcaModel.train(template, shapes, PcaConfig(config.latent, config.seed))
    return IntrinsicModel.train(template, shapes, IntrinsicConfig(config.latent, config.seed))


def _curves(records: list[EpochRecord], height: float) -> dict[str, list[tuple[int, float]]]:
    errors = {
        "train": [(record.epoch, record.train_error) for record in records],
        "test": [(record.epoch, record.validation_error) for record in records if record.validation_error is not None],
    }
    return {split: [(epoch, 100 * error / height) for epoch, error in pairs] for split, pairs in errors.items()}


def _network_fields(network: torch.nn.Module, codes: torch.Tensor) -> Fields:
    """The displacements of codes (N, D)."""

    @torch.no_grad()
    def displace(number: int, points: Points) -> torch.Tensor:
        return network(codes[number : number + 1], points)[0]

    return displace


def _model_fields(model: ShapeModel, surface: Surface, shapes: np.ndarray) -> Fields:
    """The displacements of the projections of shapes on a linear model."""

    def displace(number: int, points: Points) -> torch.Tensor:
        shape = model.decode(model.encode(shapes[number].astype(np.float64)))
        return points.values(surface.displacements(shape))

    return displace


class _Measure:
    """Mean distances in percent of the head's height: training meshes, unseen ones, unseen ones between vertices."""

    def __init__(self, meshes: TrainingMeshes, height: float, seed: int) -> None:
        surface = meshes.surface
        between = surface.draw(SURFACE_POINTS, 0.0, np.random.default_rng([seed, TrainingSeed.SURFACE]))
        vertices = surface.at_vertices()
        self.percent = 100 / (surface.box.scale * height)
        shapes = surface.displacements(meshes.shapes)
        unseen = surface.displacements(meshes.unseen)
        self.tasks = ((shapes, vertices), (unseen, vertices), (unseen, between))

    def __call__(self, trained: Fields, new: Fields) -> tuple[float, float, float]:
        """trained, new: of the training and of the unseen meshes."""
        seen, unseen, between = self.tasks
        return self._mean(trained, *seen), self._mean(new, *unseen), self._mean(new, *between)

    def _mean(self, displace: Fields, shapes: torch.Tensor, points: Points) -> float:
        gaps = (displace(k, points) - points.values(shape) for k, shape in enumerate(shapes))
        return self.percent * float(torch.stack([gap.norm(dim=-1).mean() for gap in gaps]).mean())
