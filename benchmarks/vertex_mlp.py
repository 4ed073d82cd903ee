"""A vertex-position MLP (deformable paper, section 4.2) trained on a dataset for a given time, as a rival.

Usage: python benchmarks/vertex_mlp.py DATASET SECONDS. All settings are those of configs/deformable/default.yaml, but
the epochs, which are as many as fit. The last line is JSON: errors in percent of the head's height, of training meshes
and of unseen people's whose codes are fitted to the end.
"""

import json
import sys
import time
from dataclasses import replace
from pathlib import Path

import torch

from caricli.data.dataset import read_dataset
from caricli.methods.evaluate.evaluate_ablation import fit_codes
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.train.surface import Surface, TrainingMeshes
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.ablation.config import AblationConfig
from caricli.models.ablation.networks import ArraySize, VertexArray
from caricli.models.deformable.config import DeformableConfig
from caricli.models.deformable.model import UnitBox
from caricli.store.network_points import load_network_points


def main():
    """Train, and print the errors."""
    data, limit = read_dataset(Path(sys.argv[1])), float(sys.argv[2])
    usual = {name: getattr(DeformableConfig(), name) for name in DeformableConfig.__dataclass_fields__}
    config = AblationConfig(**usual | {"precision": "float32", "validate_every": 10**6})
    shapes, unseen = data.vertices[data.rows("train")], data.vertices[spread_rows(data.rows("test"), 100)]
    surface = Surface(UnitBox(load_network_points(data.template)), data.template.faces)
    meshes = TrainingMeshes(surface, shapes, unseen)

    def begin(epochs):
        generator = torch.Generator().manual_seed(config.seed)
        size = ArraySize(config.latent, config.array_hidden, len(data.template.vertices))
        network = VertexArray(size, config.latent_std, generator, positions=True)
        return AutoDecoderTraining(network, meshes, replace(config, epochs=epochs))

    trial = begin(10**6).epochs()
    next(trial)
    start = time.perf_counter()
    next(trial)
    training = begin(max(1, int(limit / (time.perf_counter() - start))))
    start = time.perf_counter()
    record = None
    for record in training.epochs():
        print(f"epoch {record.epoch} of {training.config.epochs}: train {record.train_error}", file=sys.stderr)
    seconds = time.perf_counter() - start
    training.network.requires_grad_(False)
    codes = fit_codes(training, config.code_steps)
    everywhere = surface.at_vertices()
    with torch.no_grad():
        gaps = [(training.network(c[None], everywhere)[0] - s) for c, s in zip(codes, training.unseen, strict=True)]
    scale = 100 / (surface.box.scale * data.template.height)
    test = scale * float(torch.stack([gap.norm(dim=-1).mean() for gap in gaps]).mean())
    train = 100 * record.train_error / data.template.height
    print(json.dumps({"epochs": record.epoch, "seconds": seconds, "train": train, "test": test}))


if __name__ == "__main__":
    main()
