"""A vertex-position MLP (deformable paper, section 4.2) trained on a dataset for a given time, as a rival.

Usage: python benchmarks/vertex_mlp.py DATASET SECONDS. All settings are the defaults of DeformableConfig, but the
epochs, which are as many as fit. The last line is JSON: errors in percent of the head's height, of the points that the
last epoch drew on training meshes, mixtures and noise among them, and of the vertices of unseen people, whose codes are
fitted to the end.
"""

import json
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path

import torch

from caricli.data.dataset import Dataset, read_dataset
from caricli.methods.evaluate.evaluate_ablation import fit_codes
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.train.deformable.surface import Surface, TrainingMeshes
from caricli.methods.train.stages import EpochRecord
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.ablation.config import AblationConfig
from caricli.models.ablation.networks import ArraySize, VertexArray
from caricli.models.deformable.config import DeformableConfig
from caricli.models.deformable.model import UnitBox
from caricli.store.network_points import load_network_points

UNSEEN = 100
"""Test meshes, of as many people as there are."""

NEVER = 10**6
"""Epochs that no training comes to."""


def training_meshes(data: Dataset) -> TrainingMeshes:
    """All training meshes of a dataset, and UNSEEN of the test ones."""
    surface = Surface(UnitBox(load_network_points(data.template)), data.template.faces)
    unseen = data.vertices[spread_rows(data.rows("test"), UNSEEN)]
    return TrainingMeshes(surface, data.vertices[data.rows("train")], unseen)


def begin(meshes: TrainingMeshes, config: AblationConfig) -> AutoDecoderTraining:
    """A training of as many epochs as the settings say."""
    generator = torch.Generator().manual_seed(config.seed)
    size = ArraySize(config.latent, config.array_hidden, meshes.shapes.shape[1])
    network = VertexArray(size, config.latent_std, generator, positions=True)
    return AutoDecoderTraining(network, meshes, config)


def epochs_within(seconds: float, meshes: TrainingMeshes, config: AblationConfig) -> int:
    """How many epochs fit, by the time of a second one."""
    trial = begin(meshes, replace(config, epochs=NEVER)).epochs()
    next(trial)
    start = time.perf_counter()
    next(trial)
    return max(1, int(seconds / (time.perf_counter() - start)))


def train(training: AutoDecoderTraining) -> EpochRecord:
    """Go through all epochs. Returns the record of the last one."""
    for record in training.epochs():
        print(f"epoch {record.epoch} of {training.config.epochs}: train {record.train_error}", file=sys.stderr)
    training.network.requires_grad_(False)
    return record


def unseen_error(training: AutoDecoderTraining, steps: int, height: float) -> float:
    """Mean distance at the vertices of the unseen meshes, percent of the head's height."""
    codes = fit_codes(training, steps)
    everywhere = training.surface.at_vertices()
    with torch.no_grad():
        pairs = zip(codes, training.unseen, strict=True)
        gaps = [training.network(code[None], everywhere)[0] - shape for code, shape in pairs]
    mean = torch.stack([gap.norm(dim=-1).mean() for gap in gaps]).mean()
    return 100 * float(mean) / (training.surface.box.scale * height)


def main() -> None:
    """Train, and print the errors."""
    data = read_dataset(Path(sys.argv[1]))
    limit = float(sys.argv[2])
    usual = asdict(DeformableConfig()) | {"precision": "float32", "validate_every": NEVER}
    config = AblationConfig(**usual)
    meshes = training_meshes(data)
    training = begin(meshes, replace(config, epochs=epochs_within(limit, meshes, config)))
    start = time.perf_counter()
    record = train(training)
    seconds = time.perf_counter() - start
    height = data.template.height
    test = unseen_error(training, config.code_steps, height)
    figures = {"epochs": record.epoch, "seconds": seconds, "train": 100 * record.train_error / height, "test": test}
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
