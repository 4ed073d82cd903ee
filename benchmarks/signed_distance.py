"""A signed distance field beside a network that deforms a template (deformable paper, section 4.1 and figure 6).

Usage: python benchmarks/signed_distance.py TRAINING TEST OUT.json [EPOCHS], both folders of `caricli dataset build`.
MESHES of TRAINING's training split train an auto-decoder of signed distances (DeepSDF: rectifiers, a code of 128 beside
the place, clamped absolute errors), the hypernetwork of `evaluate ablation` for EPOCHS (its default), and principal
components. The first gets as many seconds of the processor as the second took, besides those in which distances are
sampled. People of TRAINING are left out of TEST; codes of UNSEEN meshes of it are fitted to the end, to signed
distances and to vertices. The surface of the first comes from marching cubes.

Errors are distances between surfaces, in percent of the head's height: of points of the true one from the other
("missed"), and of points of the other from the true one ("added"). Necks are closed by a fan, because only a closed
surface has a sign; what lies on the fan does not count. A field tells neither which point is which, nor has it a mesh
that stays the same: no error at vertices, landmarks, textures or rigs.
"""

import json
import sys
import time
from pathlib import Path

import igl
import numpy as np
import torch
from skimage.measure import marching_cubes

from caricli.data.dataset import read_dataset
from caricli.data.unseen import seen_people, unseen_data
from caricli.methods.evaluate.evaluate_ablation import fit_codes
from caricli.methods.evaluate.evaluate_shape import split_rows
from caricli.methods.train.deformable.surface import Surface, TrainingMeshes
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.ablation.config import AblationConfig
from caricli.models.deformable.model import UnitBox
from caricli.models.deformable.networks import HyperSiren
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel
from caricli.store.network_points import load_network_points

MESHES = 300
UNSEEN = 12
NEAR = 10_000
"""Samples of a mesh about its surface, half of them by each of SPREADS, in coordinates from -1 to 1."""

SPREADS = (0.0125, 0.05)
FAR = 2_000
"""Samples of a mesh anywhere."""

ROOM = 1.1
"""Half the size of the cube in which fields are sampled."""

CODE = 128
CODE_SPREAD = 0.01
WIDTH = 256
CLAMP = 0.1
CODE_WEIGHT = 1e-4
RATE = 1e-3
BATCH = 16
POINTS = 512
CODE_STEPS = 400
CODE_RATE = 3e-3
COARSE = 43
FINE = 4
"""Cells of the marching cubes along an edge, and how many of them each near the surface becomes."""

MEASURED = 20_000
"""Points of a surface."""


def closed(faces, count):
    """Faces with a fan over the only hole, about a further vertex, number count."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    backward = {(b, a) for a, b in edges}
    rim = np.array([(a, b) for a, b in edges if (a, b) not in backward])
    return np.concatenate([faces, np.column_stack([rim[:, ::-1], np.full(len(rim), count)])]), np.unique(rim)


class Heads:
    """Closed meshes in coordinates from -1 to 1."""

    def __init__(self, template, box):
        self.box = box
        self.open = template.faces
        self.faces, self.rim = closed(template.faces, len(template.vertices))

    def close(self, vertices):
        """Metres (V, 3) to (V + 1, 3)."""
        own = self.box.normalise(vertices.astype(float))
        return np.vstack([own, own[self.rim].mean(0)])

    def distances(self, vertices, points):
        """Signed distances of points (n, 3) from a closed mesh (V + 1, 3), negative inside."""
        way = igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER
        return igl.signed_distance(points, vertices, self.faces, sign_type=way)[0]

    def sample(self, vertices, generator):
        """Places (n, 3) and signed distances (n,) of a mesh (V, 3) in metres, float32."""
        own = self.close(vertices)
        near = surface_points(own, self.faces, NEAR, generator)
        near += generator.normal(size=near.shape) * np.repeat(SPREADS, NEAR // 2)[:, None]
        places = np.concatenate([near, generator.uniform(-ROOM, ROOM, (FAR, 3))])
        return places.astype("f4"), self.distances(own, places).astype("f4")


def surface_points(vertices, faces, count, generator):
    """Points (count, 3), uniform on a surface."""
    areas = igl.doublearea(vertices, faces)
    chosen = generator.choice(len(faces), count, p=areas / areas.sum())
    return np.einsum("nk,nkd->nd", generator.dirichlet(np.ones(3), count), vertices[faces[chosen]])


class Field(torch.nn.Module):
    """Signed distances from codes (..., CODE) and places (..., 3); both come again half-way."""

    def __init__(self):
        super().__init__()
        sizes = [(CODE + 3, WIDTH), (WIDTH, WIDTH), (WIDTH + CODE + 3, WIDTH), (WIDTH, WIDTH), (WIDTH, 1)]
        self.layers = torch.nn.ModuleList(torch.nn.Linear(*size) for size in sizes)

    def forward(self, codes, places):
        """Signed distances (...)."""
        given = torch.cat([codes.expand(*places.shape[:-1], -1), places], -1)
        x = given
        for k, layer in enumerate(self.layers[:-1]):
            x = torch.relu(layer(torch.cat([x, given], -1) if k == 2 else x))
        return self.layers[-1](x)[..., 0]


def loss_of(field, codes, places, true):
    """DeepSDF's. codes: (B, CODE). places: (B, n, 3). true: (B, n)."""
    errors = field(codes[:, None], places).clamp(-CLAMP, CLAMP) - true.clamp(-CLAMP, CLAMP)
    return errors.abs().mean() + CODE_WEIGHT * codes.square().sum(1).mean()


def drawn(samples, rows, generator):
    """Of the samples of a few meshes as many as POINTS, anew."""
    places, true = samples
    ids = torch.randint(places.shape[1], (len(rows), POINTS), generator=generator)
    return places[rows[:, None], ids], true[rows[:, None], ids]


def train_field(samples, seconds):
    """A Field of samples (N, n, 3) and (N, n), and its steps, after so many seconds of the processor."""
    torch.manual_seed(0)
    generator = torch.Generator().manual_seed(0)
    field = Field()
    codes = torch.nn.Parameter(CODE_SPREAD * torch.randn(len(samples[0]), CODE, generator=generator))
    adam = torch.optim.Adam([*field.parameters(), codes], RATE)
    start = time.process_time()
    steps = 0
    while (past := (time.process_time() - start) / seconds) < 1:
        adam.param_groups[0]["lr"] = RATE * (1 + np.cos(np.pi * past)) / 2
        rows = torch.randint(len(codes), (BATCH,), generator=generator)
        descend(adam, loss_of(field, codes[rows], *drawn(samples, rows, generator)))
        steps += 1
    return field.requires_grad_(False), steps


def fit_field(field, samples):
    """Codes (U, CODE) of unseen samples."""
    generator = torch.Generator().manual_seed(1)
    codes = torch.nn.Parameter(torch.zeros(len(samples[0]), CODE))
    adam = torch.optim.Adam([codes], CODE_RATE)
    fall = torch.optim.lr_scheduler.CosineAnnealingLR(adam, CODE_STEPS)
    rows = torch.arange(len(codes))
    for _ in range(CODE_STEPS):
        descend(adam, loss_of(field, codes, *drawn(samples, rows, generator)))
        fall.step()
    return codes.detach()


def descend(adam, loss):
    """One step."""
    adam.zero_grad()
    loss.backward()
    adam.step()


def field_surface(field, code):
    """Vertices and faces of a field's surface."""

    def at(places):
        pieces = torch.from_numpy(places.astype("f4")).split(65536)
        return torch.cat([field(code, piece) for piece in pieces]).numpy()

    ticks = np.linspace(-ROOM, ROOM, COARSE * FINE)
    middles = ticks.reshape(COARSE, FINE).mean(1)
    rough = at(np.stack(np.meshgrid(middles, middles, middles, indexing="ij"), -1).reshape(-1, 3))
    values = rough.reshape(COARSE, COARSE, COARSE)
    for axis in range(3):
        values = values.repeat(FINE, axis)
    near = np.argwhere(np.abs(values) < 2.5 * ROOM / COARSE)
    values[tuple(near.T)] = at(ticks[near])
    vertices, faces, _, _ = marching_cubes(values, 0.0)
    return vertices * (ticks[1] - ticks[0]) - ROOM, faces


def gaps(heads, truth, surface):
    """Mean distances between the true mesh (V + 1, 3) and a surface: of its points from that, and of that's from it."""
    generator = np.random.default_rng(2)
    own = surface_points(truth, heads.open, MEASURED, generator)
    vertices, faces = surface
    missed = igl.point_mesh_squared_distance(own, vertices, faces)[0]
    others = surface_points(vertices, faces, MEASURED, generator)
    squares, places, _ = igl.point_mesh_squared_distance(others, truth, heads.faces)
    return np.sqrt(missed).mean(), np.sqrt(squares[places < len(heads.open)]).mean()


def row(heads, truths, surfaces, height, **told):
    """Figures of a method, from surfaces of every true mesh."""
    errors = [gaps(heads, truth, surface) for truth, surface in zip(truths, surfaces, strict=True)]
    missed, added = 100 / (heads.box.scale * height) * np.mean(errors, axis=0)
    return {"missed": float(missed), "added": float(added)} | told


def main(training, test, out, epochs=AblationConfig.epochs):
    """Train, measure, and write the figures."""
    torch.set_num_threads(1)
    data = read_dataset(Path(training))
    others = unseen_data(read_dataset(Path(test)), {"training": seen_people(data)}, everyone=True).data
    shapes = data.vertices[split_rows(data, "train", 1, MESHES)]
    unseen = others.vertices[split_rows(others, "test", 1, UNSEEN)]
    template = data.template
    heads = Heads(template, UnitBox(load_network_points(template)))
    truths = [heads.close(shape) for shape in unseen]

    config = AblationConfig(points=512, epochs=int(epochs), validate_every=int(epochs), validation_steps=1)
    meshes = TrainingMeshes(Surface(heads.box, template.faces), shapes, unseen)
    start = time.process_time()
    network = HyperSiren(config.size(), torch.Generator().manual_seed(0), getattr(torch, config.precision))
    run = AutoDecoderTraining(network, meshes, config)
    for record in run.epochs():
        print(record.epoch, record.train_error, file=sys.stderr, flush=True)
    seconds = time.process_time() - start
    network.requires_grad_(False)
    network.precision = torch.float32
    codes = fit_codes(run, config.code_steps)
    with torch.no_grad():
        moved = network(codes, run.surface.at_vertices()).numpy()
    deformed = [(heads.close(own / heads.box.scale + heads.box.points), heads.faces) for own in moved]

    pca = PcaModel.train(template, shapes, PcaConfig(CODE, 0))
    linear = [(heads.close(shape), heads.faces) for shape in pca.decode(pca.encode(unseen.astype(float)))]

    generator = np.random.default_rng(0)
    sampled = [
        tuple(
            map(torch.from_numpy, map(np.stack, zip(*(heads.sample(shape, generator) for shape in own), strict=True)))
        )
        for own in (shapes, unseen)
    ]
    print("sampled", file=sys.stderr, flush=True)
    field, steps = train_field(sampled[0], seconds)
    print("trained", steps, file=sys.stderr, flush=True)
    surfaces = [field_surface(field, code) for code in fit_field(field, sampled[1])]

    rows = {
        "signed distances": row(heads, truths, surfaces, template.height, seconds=seconds, steps=steps),
        "SIREN hypernetwork": row(heads, truths, deformed, template.height, seconds=seconds),
        "PCA": row(heads, truths, linear, template.height),
        "mean head": row(heads, truths, [(heads.close(shapes.mean(0)), heads.faces)] * len(truths), template.height),
    }
    Path(out).write_text(json.dumps({"rows": rows, "meshes": len(shapes), "unseen": len(unseen)}, indent=1))
    np.savez(Path(out).with_suffix(".npz"), vertices=surfaces[0][0], faces=surfaces[0][1], truth=truths[0])
    print(json.dumps(rows))


if __name__ == "__main__":
    main(*sys.argv[1:])
