"""The deformable model's slow paths beside the paper's figures, and the same of the other bundled models.

Usage: python benchmarks/deformable.py [MODEL]. MODEL is a trained deformable model (default: the bundled one). Times
are medians of five runs after a warm-up; a column for CUDA where there is a device. The last line is JSON. The paper's
figures are those of one Titan Xp, for training of two (sections 4.3 and 5.5, supplement 3).
"""

import copy
import json
import statistics
import sys
import time
from pathlib import Path

import numpy as np
import torch

from caricli.io.bundled import asset_path
from caricli.io.landmarks import read_landmarks
from caricli.methods.faces.subdivide_face import subdivide_face
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.train.deformable.surface import Surface, TrainingMeshes
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.deformable.config import DeformableConfig
from caricli.models.deformable.networks import HyperSiren, siren
from caricli.models.kinds import KINDS
from caricli.store.models import load_model
from caricli.structures import Face
from caricli.template.fine_mesh import fine_mesh

ASTRONAUT = Path(__file__).parents[1] / "examples" / "astronaut" / "landmarks.json"
REPEATS = 5
"""Runs whose median is the time, after one to warm up."""

LEVELS = 3
"""Subdivisions: 64 triangles for each."""

TRAINING_STEPS = 4
"""Steps of an epoch whose time is measured."""

DECODED = {11_551: 0.017, 739_183: 0.987}
"""What the paper needs, seconds: for this many points,"""
LANDMARKS = 0.5
"""for the landmarks of a face,"""
TRAINED = 1500 * 1268 * 23_132 / 7200
"""and points a second in training: 1,500 epochs of 1,268 meshes at 23,132 points took two hours."""


def seconds(action):
    """The median time of an action."""
    action()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def decoding(model, cuda):
    """Yield a row for each of the paper's numbers of points, spread over the surface."""
    latent = typical_latent(model)
    for count, paper in DECODED.items():
        places = Surface(model.box, model.template.faces).draw(count, 0.0, np.random.default_rng(0)).positions
        points = places.numpy() / model.box.scale + model.box.centre
        row = {"what": f"decode {count:,} points, s", "paper": paper}
        row["cpu"] = seconds(lambda points=points: model.decode_at(latent, points))
        if cuda:
            row["cuda"] = seconds(decoding_on_cuda(model.network, latent, places))
        yield row


def decoding_on_cuda(network, latent, places):
    """The same on the GPU, from a latent there to displacements there."""
    network = copy.deepcopy(network).cuda()
    latent = torch.from_numpy(latent.astype(np.float32)).cuda()
    places = places.cuda()

    def decode():
        siren(places, network.weights(latent), network.size.frequency)
        torch.cuda.synchronize()

    return decode


def uses(models, marks):
    """Yield rows for what every model does, in a command with the model loaded."""
    fine = fine_mesh(next(iter(models.values())).template, LEVELS)
    for kind, model in models.items():
        model.prepare()
        latent = typical_latent(model)
        face = Face(model.template.with_vertices(model.decode(latent)), latent=latent)
        yield {
            "what": f"--subdivide {LEVELS}, {fine.weights.shape[0]:,} vertices, {kind}, s",
            "cpu": seconds(lambda model=model, face=face: subdivide_face(face, model, fine)),
        }
        yield {
            "what": f"reconstruct from landmarks, {kind}, s",
            "paper": LANDMARKS if kind == "deformable" else None,
            "cpu": seconds(lambda model=model: fit_landmarks(marks, model, "latent")),
        }
        yield {"what": f"encode, {kind}, s", "cpu": seconds(lambda model=model, face=face: model.encode(face.vertices))}


def training(model, cuda):
    """One row: points of meshes a second with the default settings; faces of the model serve as training meshes."""
    config = DeformableConfig(epochs=10**6, validate_every=10**6, start="random")
    shapes = model.decode(model.prior.sample(np.random.default_rng(0), TRAINING_STEPS * config.batch))
    work = TRAINING_STEPS * config.batch * config.points
    row = {"what": "training, points/s", "paper": TRAINED}
    for device in ("cpu", "cuda") if cuda else ("cpu",):
        network = HyperSiren(config.size(), torch.Generator().manual_seed(0), getattr(torch, config.precision))
        surface = Surface(model.box, model.template.faces, device)
        epochs = AutoDecoderTraining(network.to(device), TrainingMeshes(surface, shapes, shapes[:0]), config).epochs()
        row[device] = work / seconds(lambda epochs=epochs: next(epochs))
    return row


def typical_latent(model):
    """A latent that is neither the mean nor far from it."""
    return model.prior.colour(np.random.default_rng(0).normal(0, 0.7, len(model.prior.mean)))


def shown(value):
    """Seconds with three digits, large numbers in millions."""
    return "" if value is None else f"{value:.3f}" if value < 1e4 else f"{value / 1e6:.2f} M"


def main():
    """Print the table and the JSON line."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else asset_path("deformable.safetensors")
    deformable = load_model(path)
    if deformable.kind != "deformable":
        sys.exit(f"{path}: expected a deformable model, found {deformable.kind}")
    models = {kind: load_model(kind=kind) for kind in KINDS if asset_path(f"{kind}.safetensors").is_file()}
    cuda = torch.cuda.is_available()
    rows = list(decoding(deformable, cuda))
    rows += uses(models | {"deformable": deformable}, read_landmarks(ASTRONAUT).points)
    rows.append(training(deformable, cuda))
    names = ["Titan Xp", f"CPU, {torch.get_num_threads()} threads", *([torch.cuda.get_device_name()] if cuda else [])]
    print(f"{'':52}", *(f"{name:>16}" for name in names))
    for row in rows:
        print(f"{row['what']:52}", *(f"{shown(row.get(key)):>16}" for key in ("paper", "cpu", "cuda")[: len(names)]))
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
