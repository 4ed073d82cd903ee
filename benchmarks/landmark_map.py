"""Landmark maps beside each other, networks as the expressions paper has them (section 3.2.1) among them.

Usage: python benchmarks/landmark_map.py TRAINING TEST OUT.json [STEPS], both folders of `caricli dataset build`, STEPS
of the networks' trainings. All but the bundled map learn from the training split of TRAINING: closed form, networks,
and regression on pairs, which is told more. Everybody of TEST is measured, without people of TRAINING or of the bundled
map's training. Errors are mean distances of 68 aligned landmarks in percent of the true ones' diagonal; of ways that
draw, and of networks with a code of style, the nearest of ten counts. Intervals are of the share below identity when
people are drawn anew.

The networks are those of CariGANs in 32 principal components of either domain: two generators of two hidden layers and
two discriminators, with adversarial, cycle and characteristic losses, weighted as published. Because one normal face
has many caricatures, some have a code of style beside the normal face, which another network reads off the caricature.
They start from chance or, on top of the closed form, add next to nothing at first. The training's end is kept, and
errors are means over a training for each of SEEDS.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from caricli.data.dataset import read_dataset
from caricli.data.unseen import seen_people, unseen_data
from caricli.methods.evaluate.evaluate_landmark_map import (
    NEAREST,
    compare,
    components,
    draws,
    error_figures,
    face_errors,
    face_pairs,
    measure_landmark_map,
)
from caricli.methods.train.see_faces import map_faces
from caricli.methods.train.train_landmark_map import learn_landmark_map
from caricli.models.landmark_map.config import LandmarkMapConfig
from caricli.models.landmark_map.model import DOMAINS, other
from caricli.store.landmark_maps import load_landmark_map

SEEDS = (0, 1, 2)
"""Of networks."""

DIMENSION = 32
WIDTH = 64
JUDGE_WIDTH = 128
ADVERSARIAL = 1.0
CYCLE = 10.0
CHARACTERISTIC = 1.0
STYLE = 1.0
"""Of the difference of a style from that which is read off its caricature: without it styles die out."""

STEPS = 1500
BATCH = 256
RATE = 1e-3
SMALL = 1e-2
"""Of the last layers' usual initial weights, where networks add to the closed form."""

NAMES = {
    "identity": "identity",
    "identity with draws": "identity, with the nearest of ten draws",
    "mean": "mean",
    "random caricatures": "random caricatures",
    "map": "closed form",
    "its likeliest caricature": "closed form, its likeliest caricature alone",
    "bundled": "the bundled map: closed form of other people",
    "paired regression": "regression on pairs",
    "paired regression with draws": "regression on pairs, with draws",
}
"""Of rows, in their order; networks come last."""

Network = torch.nn.Module


@dataclass(frozen=True, eq=False)
class Codes:
    """Principal components of a domain. mean: (136,). basis: (D, 136) orthonormal. size: of the codes."""

    mean: torch.Tensor
    basis: torch.Tensor
    size: float

    def encode(self, points):
        """Landmarks (N, 68, 2) to codes (N, D)."""
        return (torch.as_tensor(points.reshape(-1, 136)).float() - self.mean) @ self.basis.T / self.size

    def decode(self, codes):
        """Codes to landmarks."""
        return (self.size * codes @ self.basis + self.mean).double().numpy().reshape(-1, 68, 2)


def domain_codes(points):
    """The Codes of landmarks (N, 68, 2)."""
    parts = components(points, DIMENSION)
    lengths = np.linalg.norm(parts, axis=1)
    mean = torch.from_numpy(points.reshape(-1, 136).mean(0)).float()
    return Codes(mean, torch.from_numpy(parts / lengths[:, None]).float(), float(lengths.mean()))


def layers(sizes, scale=1.0):
    """A network of leaky rectifiers. scale: of the last layer's initial weights."""
    pairs = [torch.nn.Linear(a, b) for a, b in zip(sizes, sizes[1:], strict=False)]
    with torch.no_grad():
        pairs[-1].weight *= scale
        pairs[-1].bias *= scale
    stack = [each for layer in pairs[:-1] for each in (layer, torch.nn.LeakyReLU(0.2))]
    return torch.nn.Sequential(*stack, pairs[-1])


class Rival:
    """Two generators, a reader of styles and two discriminators. start: LandmarkMap that they add to, or None."""

    def __init__(self, seen, styles, start, seed=0):
        torch.manual_seed(seed)
        self.codes = {name: domain_codes(seen[name]) for name in DOMAINS}
        self.styles = styles
        self.start = start
        scale = 1.0 if start is None else SMALL
        self.to_normal = layers((DIMENSION, WIDTH, WIDTH, DIMENSION), scale)
        self.to_caricature = layers((DIMENSION + styles, WIDTH, WIDTH, DIMENSION), scale)
        self.reader = layers((DIMENSION, WIDTH, styles)) if styles else self._no_style
        self.judges = {name: layers((DIMENSION, JUDGE_WIDTH, JUDGE_WIDTH, 1)) for name in DOMAINS}
        self.linear = self._closed_form() if start is not None else None

    def _closed_form(self):
        """Weights and constants of the closed form, between codes."""
        normal, caricature = (self.codes[name] for name in DOMAINS)

        def caught(rows, own):
            return torch.as_tensor(rows).float() @ own.basis.T / own.size

        back = caught(caricature.basis @ torch.from_numpy(self.start.to_normal).float(), normal) * caricature.size
        forth = caught(normal.basis, caricature) * normal.size
        moved = caught(
            normal.mean + torch.from_numpy(self.start.caricature - self.start.normal) - caricature.mean, caricature
        )
        return back, forth, moved, caught(self.start.styles, caricature)

    def _no_style(self, codes):
        return codes[:, :0]

    def normal(self, codes):
        """Codes of caricatures to those of normal faces."""
        added = self.to_normal(codes)
        return added if self.linear is None else codes @ self.linear[0] + added

    def caricature(self, codes, style):
        """Codes of normal faces, and styles, to those of caricatures."""
        added = self.to_caricature(torch.cat([codes, style], 1))
        if self.linear is None:
            return added
        _, forth, moved, styles = self.linear
        return codes @ forth + moved + style @ styles + added

    def train(self, seen, steps):
        """Learn from aligned landmarks (N, 68, 2) by domain."""
        generator = torch.Generator().manual_seed(1)
        data = {name: self.codes[name].encode(seen[name]) for name in DOMAINS}
        networks = [self.to_normal, self.to_caricature, *([self.reader] if self.styles else [])]
        optimiser = torch.optim.Adam([w for net in networks for w in net.parameters()], RATE, (0.5, 0.999))
        judging = torch.optim.Adam([w for net in self.judges.values() for w in net.parameters()], RATE, (0.5, 0.999))
        for step in range(steps):
            for group in (*optimiser.param_groups, *judging.param_groups):
                group["lr"] = RATE * min(1, 2 * (1 - step / steps))
            real = {n: own[torch.randint(len(own), (BATCH,), generator=generator)] for n, own in data.items()}
            style = torch.randn(BATCH, self.styles, generator=generator)
            fakes = {"normal": self.normal(real["caricature"]), "caricature": self.caricature(real["normal"], style)}
            fooling = sum((self.judges[n](fakes[n]) - 1).square().mean() for n in DOMAINS)
            descend(optimiser, ADVERSARIAL * fooling + self._keeping(real, fakes, style))
            doubts = sum(
                (judge(real[n]) - 1).square().mean() + judge(fakes[n].detach()).square().mean()
                for n, judge in self.judges.items()
            )
            descend(judging, doubts)

    def _keeping(self, real, fakes, style):
        back = {
            "normal": self.normal(fakes["caricature"]),
            "caricature": self.caricature(fakes["normal"], self.reader(real["caricature"])),
        }
        cycle = sum((back[n] - real[n]).norm(dim=1).mean() for n in DOMAINS) / DIMENSION**0.5
        pairs = ((real["normal"], fakes["caricature"]), (fakes["normal"], real["caricature"]))
        ways = [[own @ self.codes[n].basis for n, own in zip(DOMAINS, pair, strict=True)] for pair in pairs]
        turn = sum(1 - torch.nn.functional.cosine_similarity(*way).mean() for way in ways)
        told = (self.reader(fakes["caricature"]) - style).square().mean() if self.styles else 0
        return CYCLE * cycle + CHARACTERISTIC * turn + STYLE * told

    @torch.no_grad()
    def map(self, pairs):
        """What it makes of caricatures (N, 68, 2) and, NEAREST times, of normal faces (K, N, 68, 2)."""
        generator = torch.Generator().manual_seed(2)
        normal, caricature = (self.codes[name] for name in DOMAINS)
        given = normal.encode(pairs.normal)
        drawn = [
            self.caricature(given, torch.randn(len(given), self.styles, generator=generator)) for _ in range(NEAREST)
        ]
        back = normal.decode(self.normal(caricature.encode(pairs.caricature)))
        return {"normal": back, "caricature": np.stack([caricature.decode(own) for own in drawn])}


def descend(optimiser, loss):
    """One step."""
    optimiser.zero_grad()
    loss.backward()
    optimiser.step()


def networks(landmark_map, seen, pairs, steps):
    """Yield names of networks and their ``over_seeds`` by domain."""
    styles = len(landmark_map.styles)
    ways = {
        "networks, as published": (0, None),
        "networks, with a code of style": (styles, None),
        "both: such networks on top of the closed form": (styles, landmark_map),
    }
    true = {"normal": pairs.normal, "caricature": pairs.caricature}
    identity = {to: face_errors(true[other(to)], true[to]) for to in DOMAINS}
    for name, (count, start) in ways.items():
        errors = {to: [] for to in DOMAINS}
        for seed in SEEDS:
            rival = Rival(seen, count, start, seed)
            rival.train(seen, steps)
            for to, points in rival.map(pairs).items():
                own = face_errors(points, true[to])
                errors[to].append(own.min(0) if own.ndim == 2 else own)
            print(name, seed, {to: round(float(own[-1].mean()), 3) for to, own in errors.items()}, file=sys.stderr)
        yield name, {to: over_seeds(own, identity[to], pairs.people) for to, own in errors.items()}


def over_seeds(errors, identity, people):
    """``error_figures`` of errors (N,) of several trainings, with the lowest and highest of their means."""
    means = [float(own.mean()) for own in errors]
    return error_figures(np.mean(errors, axis=0), identity, people) | {"lowest": min(means), "highest": max(means)}


def bundled(landmark_map, pairs):
    """``error_figures`` of a map by domain."""
    likeliest = landmark_map.map_aligned(pairs.normal, "caricature")
    back = landmark_map.map_aligned(pairs.caricature, "normal")
    to_normal = {"identity": pairs.caricature, "bundled": back}
    to_caricature = {"identity": pairs.normal, "bundled": draws(likeliest, landmark_map.styles)}
    return {
        "normal": compare(to_normal, pairs.normal, pairs.people)["bundled"],
        "caricature": compare(to_caricature, pairs.caricature, pairs.people)["bundled"],
    }


def main(training, test, out, steps=STEPS):
    """Measure, and write the figures."""
    torch.set_num_threads(1)
    shipped = load_landmark_map()
    config = LandmarkMapConfig()
    data = read_dataset(Path(training))
    faces = map_faces(data, config.views, 0)
    seen = {"landmark map": shipped.seen, "training": seen_people(data)}
    people = unseen_data(read_dataset(Path(test)), seen, everyone=True)
    strangers = map_faces(people.data, config.views, 0)
    pairs = face_pairs(strangers, "test")
    landmark_map = learn_landmark_map(faces.seen["training"], config)
    figures = measure_landmark_map(landmark_map, pairs, face_pairs(faces, "training"))
    for to, own in bundled(shipped, pairs).items():
        figures[to]["bundled"] = own
    rows = {
        title: {to: figures[to][name] for to in DOMAINS if name in figures[to]} for name, title in NAMES.items()
    } | dict(networks(landmark_map, faces.seen["training"], pairs, int(steps)))
    count = len(strangers.rows["test"]["caricature"])
    told = {"landmark_map": rows, "spread": figures["spread"], "caricatures": count} | people.figures
    Path(out).write_text(json.dumps(told, indent=1))
    print(json.dumps(told))


if __name__ == "__main__":
    main(*sys.argv[1:])
