"""The landmark map beside its rivals, networks as the expressions paper has them (section 3.2.1) among them.

Usage: python benchmarks/landmark_map.py TRAINING TEST OUT.json, both folders of `caricli dataset build`. Everybody of
TEST whom the bundled map has not seen is measured; networks and regressions learn from the training split of TRAINING,
as the bundled map did. Errors are mean distances of 68 aligned landmarks in percent of the true ones' diagonal; of ways
that draw the nearest of ten counts. Intervals are of the share below identity when people are drawn anew.

The networks are those of CariGANs in 32 principal components of either domain: two generators of two hidden layers and
two discriminators, with adversarial, cycle and characteristic losses, weighted as published; and, because one normal
face has many caricatures, a code of style beside the normal face, which another network reads off the caricature.
"alone" they start from chance; "both" add to the closed form, from next to nothing. The training's end is kept.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from caricli.data.dataset import read_dataset
from caricli.data.unseen import unseen_data
from caricli.methods.evaluate.evaluate_landmark_map import (
    NEAREST,
    compare,
    components,
    face_pairs,
    measure_landmark_map,
)
from caricli.methods.train.see_faces import map_faces
from caricli.models.landmark_map.model import DOMAINS
from caricli.store.landmark_maps import load_landmark_map

VIEWS = 8
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
        self.reader = layers((DIMENSION, WIDTH, styles))
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

    def train(self, seen):
        """Learn from aligned landmarks (N, 68, 2) by domain."""
        generator = torch.Generator().manual_seed(1)
        data = {name: self.codes[name].encode(seen[name]) for name in DOMAINS}
        networks = (self.to_normal, self.to_caricature, self.reader)
        optimiser = torch.optim.Adam([w for net in networks for w in net.parameters()], RATE, (0.5, 0.999))
        judging = torch.optim.Adam([w for net in self.judges.values() for w in net.parameters()], RATE, (0.5, 0.999))
        for step in range(STEPS):
            for group in (*optimiser.param_groups, *judging.param_groups):
                group["lr"] = RATE * min(1, 2 * (1 - step / STEPS))
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
        told = (self.reader(fakes["caricature"]) - style).square().mean()
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


def rivals(landmark_map, seen, pairs):
    """``compare`` of networks alone and on top of the closed form, by domain."""
    made = {}
    for name, start in (("networks alone", None), ("both", landmark_map)):
        rival = Rival(seen, len(landmark_map.styles), start)
        rival.train(seen)
        made[name] = rival.map(pairs)
    true = {"normal": pairs.normal, "caricature": pairs.caricature}
    given = {"normal": pairs.caricature, "caricature": pairs.normal}
    return {
        to: compare({"identity": given[to]} | {name: own[to] for name, own in made.items()}, true[to], pairs.people)
        for to in DOMAINS
    }


def by_name(figures):
    """Figures by rival and domain, from those by domain and rival."""
    order = {name: None for to in ("caricature", "normal") for name in figures[to]}
    return {name: {to: figures[to][name] for to in DOMAINS if name in figures[to]} for name in order}


def main(training, test, out):
    """Measure, and write the figures."""
    torch.set_num_threads(1)
    landmark_map = load_landmark_map()
    faces = map_faces(read_dataset(Path(training)), VIEWS, 0)
    people = unseen_data(read_dataset(Path(test)), {"landmark map": landmark_map.seen}, everyone=True)
    strangers = map_faces(people.data, VIEWS, 0)
    pairs = face_pairs(strangers, "test")
    figures = measure_landmark_map(landmark_map, pairs, face_pairs(faces, "training"))
    for to, own in rivals(landmark_map, faces.seen["training"], pairs).items():
        figures[to] |= own
    count = len(strangers.rows["test"]["caricature"])
    told = {"landmark_map": by_name(figures), "spread": figures["spread"], "caricatures": count} | people.figures
    Path(out).write_text(json.dumps(told, indent=1))
    print(json.dumps(told))


if __name__ == "__main__":
    main(*sys.argv[1:])
