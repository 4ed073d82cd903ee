"""Errors of unseen people's meshes against the number of training meshes: PCA, Gaussian process, MLP and network.

Usage: python -m benchmarks.training_sizes FOLDER DATASET... [--sizes N ...] [--models NAME ...] [--steps N]
[--limit S].
FOLDER keeps every row that is done, and the state of a training after every few seconds: stopped, or at its --limit of
seconds, the command goes on from there when it is given again. Networks take the same number of --steps whatever the
number of meshes, the deformable one at the paper's width with its weight of latents (`paper`) or without (`network`).
Several --steps are rounds of cosine schedules (Loshchilov and Hutter 2017), each from the weights of the one before.
Sizes are nested, spread evenly over the training meshes. The last line is JSON: rows; and curves, of each model its
errors by size with the power law ``error = scale * meshes^-exponent`` that fits them best in logarithms, the root mean
square of what it leaves, in percent of the errors, and where it would meet that of PCA.
"""

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path

import numpy as np
import torch

from benchmarks.vertex_mlp import NEVER, UNSEEN, unseen_error
from caricli.data.dataset import Dataset, read_dataset
from caricli.io.training_state import read_state, write_state
from caricli.methods.evaluate.evaluate_shape import evaluate_shape, spread_rows
from caricli.methods.train.deformable.surface import Surface, TrainingMeshes
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.ablation.config import AblationConfig
from caricli.models.ablation.networks import ArraySize, VertexArray
from caricli.models.deformable.config import DeformableConfig
from caricli.models.deformable.model import UnitBox
from caricli.models.deformable.networks import HyperSiren
from caricli.models.kernel.config import KernelConfig
from caricli.models.kernel.model import KernelModel
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel
from caricli.store.network_points import load_network_points

SIZES = (250, 500, 1000, 2000, 3600)
LINEAR = ("pca", "kernel")
NETWORKS = ("mlp", "network", "paper")
DIMENSION = 128

KEPT = 20
"""Seconds between two states of a training."""

PARALLEL = 0.01
"""Difference of two exponents below which lines count as parallel."""


def settings(name: str, steps: int, meshes: int) -> AblationConfig:
    """Of a network's training: the defaults of DeformableConfig, for so many steps."""
    usual = asdict(DeformableConfig()) | {"validate_every": NEVER}
    if name == "mlp":
        usual |= {"precision": "float32"}
    else:
        usual |= {"hidden": 256}
    if name == "paper":
        usual |= {"latent_weight": 1e6, "prior_weight": 0.0}
    config = AblationConfig(**usual)
    return replace(config, epochs=max(1, steps // max(1, meshes // config.batch)))


def linear_row(name: str, data: Dataset, shapes: np.ndarray, unseen: np.ndarray) -> dict:
    """Figures of a model that is computed at once."""
    start = time.perf_counter()
    if name == "pca":
        model = PcaModel.train(data.template, shapes, PcaConfig(DIMENSION))
    else:
        model = KernelModel.train(data.template, shapes, KernelConfig(DIMENSION))
    seconds = time.perf_counter() - start
    train = evaluate_shape(model, shapes[:: max(1, len(shapes) // UNSEEN)])
    test = evaluate_shape(model, unseen)
    assert train is not None and test is not None
    return {"train": train.percent, "test": test.percent, "seconds": seconds}


def network_row(
    config: AblationConfig, data: Dataset, meshes: tuple[np.ndarray, np.ndarray], rounds: list[Path], end: float
) -> dict | None:
    """Figures of a trained network; None where its time was over first.

    meshes: rows to train with, and shapes (U, V, 3) that are unseen. rounds: files of the state of this training, last,
    and of those before it. end: by the monotonic clock.
    """
    ids, unseen = meshes
    as_array = config.precision == "float32"
    generator = torch.Generator().manual_seed(config.seed)
    network: torch.nn.Module
    if as_array:
        size = ArraySize(config.latent, config.array_hidden, len(data.template.vertices))
        network = VertexArray(size, config.latent_std, generator, positions=True)
    else:
        network = HyperSiren(config.size(), generator, getattr(torch, config.precision))
    surface = Surface(UnitBox(load_network_points(data.template)), data.template.faces)
    training = AutoDecoderTraining(network, TrainingMeshes(surface, data.vertices[ids], unseen), config)
    *before, state = rounds
    if state.is_file():
        training.load_state(read_state(state)[0])
    elif before:
        begin_with(training, read_state(before[-1])[0])
    kept = time.monotonic()
    for record in training.epochs():
        over = time.monotonic() > end
        if over or training.ended or time.monotonic() > kept + KEPT:
            write_state(state, training.state(), asdict(config))
            kept = time.monotonic()
            print(f"{state.stem}: epoch {record.epoch} of {config.epochs}, {record.train_error}", flush=True)
        if over and not training.ended:
            return None
    training.network.requires_grad_(False)
    if not as_array:
        network.precision = torch.float32
    test = unseen_error(training, config.code_steps, data.template.height)
    return {"train": seen_error(training, data.template.height), "test": test, "epochs": config.epochs}


def seen_error(training: AutoDecoderTraining, height: float) -> float:
    """Mean distance at the vertices of about UNSEEN training meshes with their own latents, percent of the height."""
    every = max(1, len(training.shapes) // UNSEEN)
    everywhere = training.surface.at_vertices()
    with torch.no_grad():
        pairs = zip(training.latents[::every], training.shapes[::every], strict=True)
        gaps = [(training.network(code[None], everywhere)[0] - shape).norm(dim=-1).mean() for code, shape in pairs]
    return 100 * float(torch.stack(gaps).mean()) / (training.surface.box.scale * height)


def begin_with(training: AutoDecoderTraining, state: dict) -> None:
    """Take over weights and latents of a training that has ended, at the highest rate again."""
    training.network.load_state_dict(state["network"])
    training.latents.data.copy_(state["latents"])
    training.codes.data.copy_(state["codes"])


def rows(folder: Path, options: argparse.Namespace) -> Iterator[dict]:
    """All rows of a dataset that can be had in time; those that are there already are read."""
    end = time.monotonic() + options.limit
    data = read_dataset(folder)
    unseen = data.vertices[spread_rows(data.rows("test"), UNSEEN)]
    for name, size in product(options.models, options.sizes):
        ids = spread_rows(data.rows("train"), size)
        if len(ids) < size:
            continue
        taken: list[Path] = []
        for k, steps in enumerate(options.steps if name in NETWORKS else [0]):
            all_steps = sum(options.steps[: k + 1]) if steps else 0
            path = options.folder / f"{folder.name}-{name}-{size}-{all_steps}.json"
            taken.append(path.with_suffix(".pt"))
            if not path.is_file():
                if name in LINEAR:
                    row = linear_row(name, data, data.vertices[ids], unseen)
                else:
                    row = network_row(settings(name, steps, size), data, (ids, unseen), taken, end)
                if row is None:
                    break
                row = {"data": folder.name, "model": name, "meshes": size, "steps": all_steps} | row
                path.write_text(json.dumps(row))
            yield json.loads(path.read_text("utf-8"))


def power_law(meshes: np.ndarray, errors: np.ndarray) -> dict[str, float]:
    """``error = scale * meshes^-exponent``, and what it leaves in percent, as a root mean square."""
    slope, level = np.polyfit(np.log(meshes), np.log(errors), 1)
    left = np.log(errors) - (slope * np.log(meshes) + level)
    return {"scale": float(np.exp(level)), "exponent": float(-slope), "left": 100 * float(np.sqrt((left**2).mean()))}


def curves(table: list[dict]) -> list[dict]:
    """Of every model its errors by number of meshes, and with three or more the power law of them."""
    lines = {}
    for key in dict.fromkeys((row["data"], row["model"], row["steps"]) for row in table):
        own = [row for row in table if (row["data"], row["model"], row["steps"]) == key]
        errors = {f"at_{row['meshes']}": row["test"] for row in own}
        lines[key] = dict(zip(("data", "name", "steps"), key, strict=True)) | {"test": errors}
        if len(own) > 2:
            lines[key] |= power_law(np.array([row["meshes"] for row in own]), np.array([*errors.values()]))
    for (data, name, _), line in lines.items():
        linear = lines.get((data, "pca", 0), {})
        # Where lines are parallel, or part, they meet at no number that anybody will have.
        steeper = line.get("exponent", 0) - linear.get("exponent", np.inf)
        if name != "pca" and steeper > PARALLEL:
            line["meets_pca"] = float((line["scale"] / linear["scale"]) ** (1 / steeper))
    return list(lines.values())


def main() -> None:
    """Print the rows as they come, and the JSON line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("datasets", type=Path, nargs="+")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES)
    parser.add_argument("--models", nargs="+", choices=LINEAR + NETWORKS, default=("pca", "kernel", "mlp", "network"))
    parser.add_argument("--steps", type=int, nargs="+", default=(17_000,))
    parser.add_argument("--limit", type=float, default=float("inf"))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    table = []
    for dataset in options.datasets:
        for row in rows(dataset, options):
            print(row, flush=True)
            table.append(row)
    print(json.dumps({"rows": table, "curves": curves(table)}))


if __name__ == "__main__":
    main()
