"""A map between the landmarks of normal faces and of caricatures, trained without pairs."""

from dataclasses import dataclass

import numpy as np
import torch
from threadpoolctl import threadpool_limits

from caricli.data.dataset import Dataset
from caricli.errors import NumericsError
from caricli.methods.evaluate.evaluate_landmark_map import evaluate_landmark_map
from caricli.methods.train.see_faces import SeenFaces, map_faces
from caricli.methods.train.stages import Report, Stages, silent, unwatched
from caricli.models.landmark_map.config import LandmarkMapConfig
from caricli.models.landmark_map.model import (
    DOMAINS,
    Domain,
    LandmarkMap,
    generate,
    map_from_checkpoint,
    map_to_checkpoint,
    other,
)
from caricli.models.principal_components import principal_components

START = 1e-2
"""Of the last layers' initial weights, a share of Kaiming's: training starts near the linear map."""

FINAL_RATE = 0.02
"""Learning rate at the end, a share of that of the first half."""

MOMENTS = (0.5, 0.999)
"""Adam's decay rates: with the usual first one generators and discriminators run after each other."""

SLOPE = 0.2
"""Of the discriminators' leaky rectifiers below zero."""

COMPARED = 1000
"""Faces of a domain between which distances are measured: their number goes with its square."""


@dataclass(frozen=True, eq=False)
class MapTraining:
    """A trained map.

    checkpoint: tensors and metadata, to be written.
    landmark_map: LandmarkMap, as it comes out of the checkpoint.
    figures: JSON object, see ``evaluate_landmark_map``.
    epochs: what was measured before the training and after every epoch.
    """

    checkpoint: tuple[dict[str, np.ndarray], dict]
    landmark_map: LandmarkMap
    figures: dict
    epochs: list[dict]


def train_landmark_map(
    data: Dataset, config: LandmarkMapConfig, seed: int, recipe: dict, stages: Stages = silent
) -> MapTraining:
    """Train a map on the faces of a dataset and measure it on those of the test split.

    seed: of all draws. recipe: JSON object, how it is trained, for the checkpoint.
    Raises InputError when a domain has too few meshes, NumericsError when its faces hardly differ or a loss is not
    finite.
    """
    with stages("looking at faces") as report:
        faces = map_faces(data, config.views, seed, report)
    with stages("training landmark-map") as report:
        trained, epochs = learn_landmark_map(faces.seen["training"], faces.seen["unseen"], config, seed, report)
    checkpoint = map_to_checkpoint(trained, recipe)
    landmark_map = map_from_checkpoint(*checkpoint, "the trained map")
    with stages("measuring") as report:
        figures = evaluate_landmark_map(landmark_map, faces, report)
    return MapTraining(checkpoint, landmark_map, figures, epochs)


def learn_landmark_map(
    training: dict[str, SeenFaces],
    unseen: dict[str, SeenFaces],
    config: LandmarkMapConfig,
    seed: int = 0,
    report: Report = unwatched,
) -> tuple[LandmarkMap, list[dict]]:
    """Learn a LandmarkMap without pairs (expressions paper, section 3.2.1).

    Both domains are reduced to principal components. The generators start as a linear map and its inverse (``_start``).
    They and two discriminators then minimise, in turn, ``adversarial`` times least-squares adversarial losses, plus
    ``cycle`` times the mean distance of landmarks that were mapped forth and back, plus ``characteristic`` times one
    minus the cosine between the differences of input and output from the means of their domains. The epoch is kept that
    is best on unseen faces by a measure that needs no pairs.

    training, unseen: by domain. seed: of all draws. report: called with finished epochs and their total.
    Returns the map, and what was measured before training and after every epoch.
    Raises NumericsError when a domain has too few different faces, or a loss is not finite.
    """
    best = np.inf
    kept: dict = {}
    records: list[dict] = []
    with threadpool_limits(1):
        run = _Training(training, unseen, config, seed)
        for epoch in range(config.epochs + 1):
            if epoch:
                run.epoch(epoch - 1)
            records.append(run.measure())
            if not np.isfinite(records[-1]["criterion"]):
                raise NumericsError(f"the loss of epoch {epoch} is not finite: a smaller learning_rate may help")
            if records[-1]["criterion"] < best:
                best = records[-1]["criterion"]
                kept = run.generators()
            report(epoch, config.epochs)
    return LandmarkMap(run.domains, kept), records


def _domain(faces: SeenFaces, dimension: int, seed: int) -> Domain:
    rows = faces.points.reshape(len(faces.points), -1)
    return Domain(*principal_components(rows, dimension, seed)[:2])


@dataclass(frozen=True, eq=False)
class _Explained:
    """Effects (F, D) of labels on codes; root (D, D) of the covariance of what they leave, its size in landmarks."""

    effects: np.ndarray
    root: np.ndarray
    deviation: float


def _start(domains: dict[str, Domain], training: dict[str, SeenFaces], least: float) -> np.ndarray:
    """The linear map from codes of caricatures to codes of normal faces, (D, D'), to begin with.

    It estimates E[normal | caricature] = caricature C. What labels explain of both codes gives one part of the
    covariance C: a face of either domain with the same labels has the same mean. The remainders of the codes are taken
    to belong together by the turn that moves the landmarks least, and to agree as far as an exaggeration would leave
    them that has nothing to do with the face: as the deviations of the two domains. Singular values below ``least`` are
    raised to it, because the inverse exaggerates by as much.
    """
    normal, caricature = (_explained(domains[name], training[name]) for name in DOMAINS)
    labels = training["caricature"].labels
    shared = (labels @ caricature.effects).T @ (labels @ normal.effects) / len(labels)
    bases = [domains[name].basis / np.linalg.norm(domains[name].basis, axis=1)[:, None] for name in DOMAINS]
    u, _, vt = np.linalg.svd(caricature.root @ bases[1] @ bases[0].T @ normal.root, full_matrices=False)
    agreement = min(1.0, normal.deviation / caricature.deviation)
    shared += agreement * caricature.root @ u @ vt @ normal.root
    u, singular, vt = np.linalg.svd(shared, full_matrices=False)
    return (u * np.clip(singular, least, 1 / least)) @ vt


def _explained(domain: Domain, faces: SeenFaces) -> _Explained:
    codes = domain.encode(faces.points)
    effects = np.linalg.lstsq(faces.labels, codes, rcond=None)[0]
    rest = codes - faces.labels @ effects
    values, vectors = np.linalg.eigh(rest.T @ rest / len(rest))
    root = (vectors * np.sqrt(np.maximum(values, 0))) @ vectors.T
    return _Explained(effects, root, float(np.linalg.norm(root @ domain.basis)))


class _Training:
    """Networks, data and what was learned so far."""

    def __init__(
        self,
        training: dict[str, SeenFaces],
        unseen: dict[str, SeenFaces],
        config: LandmarkMapConfig,
        seed: int,
    ) -> None:
        self.config = config
        self.generator = torch.Generator().manual_seed(seed)
        self.domains = {name: _domain(training[name], config.dimension, seed) for name in DOMAINS}
        self.bases = {name: torch.from_numpy(self.domains[name].basis).float() for name in DOMAINS}
        self.size = {name: float(self.bases[name].norm()) for name in DOMAINS}
        self.codes = self._codes(training)
        self.unseen = self._codes(unseen)
        start = _start(self.domains, training, config.least)
        starts = {"normal": start, "caricature": np.linalg.pinv(start)}
        self.networks = {name: self._network(starts[name]) for name in DOMAINS}
        self.judges = {name: _judge(len(self.bases[name]), config.judge_width, self.generator) for name in DOMAINS}
        mapping = [weight for network in self.networks.values() for weight in network.values()]
        judging = [weight for judge in self.judges.values() for weight in judge.parameters()]
        self.optimiser = torch.optim.Adam(mapping, lr=config.learning_rate, betas=MOMENTS)
        self.judge_optimiser = torch.optim.Adam(judging, lr=config.learning_rate, betas=MOMENTS)

    def _codes(self, faces: dict[str, SeenFaces]) -> dict[str, torch.Tensor]:
        return {name: torch.from_numpy(self.domains[name].encode(faces[name].points)).float() for name in DOMAINS}

    def _network(self, linear: np.ndarray) -> dict[str, torch.Tensor]:
        width = self.config.width
        start, end = linear.shape
        values = {
            "linear": torch.from_numpy(linear).float(),
            "first": self._drawn(start, width),
            "first_bias": torch.zeros(width),
            "second": self._drawn(width, width),
            "second_bias": torch.zeros(width),
            "last": self._drawn(width, end, START),
            "last_bias": torch.zeros(end),
        }
        return {name: value.requires_grad_() for name, value in values.items()}

    def _drawn(self, rows: int, columns: int, scale: float = 1.0) -> torch.Tensor:
        return scale * (2 / rows) ** 0.5 * torch.randn(rows, columns, generator=self.generator)

    def generators(self) -> dict[str, dict[str, np.ndarray]]:
        """The generators' weights as arrays."""
        return {
            name: {key: value.detach().numpy().astype(np.float64) for key, value in net.items()}
            for name, net in self.networks.items()
        }

    def epoch(self, number: int) -> None:
        """Go once through as many faces as the larger domain has."""
        config = self.config
        steps = -(-max(len(codes) for codes in self.codes.values()) // config.batch)
        for step in range(steps):
            # Constant for half of the time, then down to nearly nothing.
            left = 1 - (number + step / steps) / config.epochs
            for group in (*self.optimiser.param_groups, *self.judge_optimiser.param_groups):
                group["lr"] = config.learning_rate * max(FINAL_RATE, min(1.0, 2 * left))
            real = {name: self._draw(self.codes[name]) for name in DOMAINS}
            fakes = {name: generate(self.networks[name], real[other(name)]) for name in DOMAINS}
            fooling = [(self.judges[name](fakes[name]) - 1).square().mean() for name in DOMAINS]
            _descend(self.optimiser, config.adversarial * (fooling[0] + fooling[1]) + self._keeping(real, fakes))
            doubts = [
                (judge(real[name]) - 1).square().mean() + judge(fakes[name].detach()).square().mean()
                for name, judge in self.judges.items()
            ]
            _descend(self.judge_optimiser, doubts[0] + doubts[1])

    def _draw(self, codes: torch.Tensor) -> torch.Tensor:
        return codes[torch.randint(len(codes), (self.config.batch,), generator=self.generator)]

    def _keeping(self, real: dict[str, torch.Tensor], fakes: dict[str, torch.Tensor]) -> torch.Tensor:
        """Cycle and characteristic losses of codes by domain and what they were mapped to, weighted."""
        loss = torch.zeros(())
        for name in DOMAINS:
            fake = fakes[other(name)]
            basis = self.bases[name]
            back = generate(self.networks[name], fake)
            # In units of how much the domain's faces differ.
            cycle = ((back - real[name]) @ basis).norm(dim=1).mean() / self.size[name]
            way = fake @ self.bases[other(name)]
            turn = 1 - torch.nn.functional.cosine_similarity(real[name] @ basis, way, dim=1).mean()
            loss = loss + self.config.cycle * cycle + self.config.characteristic * turn
        return loss

    @torch.no_grad()
    def measure(self) -> dict:
        """Of unseen faces: how far mapped codes are from real ones as distributions, and what else was minimised."""
        fakes = {name: generate(self.networks[name], self.unseen[other(name)]) for name in DOMAINS}
        distances = {name: _energy_distance(fakes[name], self.unseen[name]) for name in DOMAINS}
        keeping = float(self._keeping(self.unseen, fakes))
        criterion = self.config.adversarial * sum(distances.values()) + keeping
        return {"criterion": criterion, "energy_distance": distances, "cycle and characteristic": keeping}


def _descend(optimiser: torch.optim.Optimizer, loss: torch.Tensor) -> None:
    optimiser.zero_grad()
    loss.backward()
    optimiser.step()


def _judge(dimension: int, width: int, generator: torch.Generator) -> torch.nn.Sequential:
    """A discriminator of codes."""
    layers = [torch.nn.Linear(a, b) for a, b in ((dimension, width), (width, width), (width, 1))]
    for layer in layers:
        torch.nn.init.kaiming_normal_(layer.weight, generator=generator)
        torch.nn.init.zeros_(layer.bias)
    first, second, last = layers
    return torch.nn.Sequential(first, torch.nn.LeakyReLU(SLOPE), second, torch.nn.LeakyReLU(SLOPE), last)


def _energy_distance(first: torch.Tensor, second: torch.Tensor) -> float:
    """Between two samples (N, D) and (M, D)."""
    first, second = (rows[:: -(-len(rows) // COMPARED)] for rows in (first, second))
    within = (torch.cdist(rows, rows).sum() / max(1, len(rows) * (len(rows) - 1)) for rows in (first, second))
    return float(2 * torch.cdist(first, second).mean() - sum(within))
