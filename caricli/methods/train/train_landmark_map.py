"""A map between the landmarks of normal faces and of caricatures, trained without pairs."""

from dataclasses import dataclass

import numpy as np
import torch
from threadpoolctl import threadpool_limits

from caricli.data.expressions import expand_sides
from caricli.errors import NumericsError
from caricli.geometry.head_rotation import TURNS, head_rotation
from caricli.geometry.similarity import similarity
from caricli.io.bundled import asset_path
from caricli.io.config import read_yaml
from caricli.methods.reconstruct.fit_landmarks import landmark_vertices
from caricli.models.landmark_map.model import COUNT, DOMAINS, WEIGHTS, Domain, LandmarkMap, align, generate, other
from caricli.models.principal_components import principal_components
from caricli.template.head import load_head

_START, _FINAL_RATE = 1e-2, 0.02
_COMPARED = 1000


@dataclass(frozen=True, eq=False)
class SeenFaces:
    """points (N, 68, 2): aligned landmarks. labels (N, F): what is known of each face beside them, with a constant."""

    points: np.ndarray
    labels: np.ndarray


def domain_rows(data):
    """Which meshes of a Dataset belong to a domain: what is exaggerated by any means is a caricature.

    Returns dict from DOMAINS to (N,) bool.
    """
    # Level counts the exaggeration of curvature alone; kind also that of parts.
    exaggerated = (data.level > 1) | (np.asarray(data.factors.get("kind", 0)) > 0)
    return {"normal": ~exaggerated, "caricature": exaggerated}


def see_faces(vertices, expressions, kinds, template, views, generator):
    """Landmarks of meshes in random poses, those of the jaw on the outline.

    vertices: (N, V, 3). expressions: (N,) whole numbers below kinds. template: Template. views: poses a
    mesh. generator: numpy Generator.
    Returns SeenFaces of N * views, labelled with expression and turn.
    """
    turns = generator.uniform(-1, 1, (len(vertices), views, 3))
    points = np.empty((len(vertices), views, COUNT, 2))
    for k, shape in enumerate(vertices):
        for view, turn in enumerate(turns[k]):
            rotation = head_rotation(turn * TURNS)
            points[k, view] = shape[landmark_vertices(shape, rotation, template, COUNT)] @ rotation[:2].T
    pitch, yaw = turns[..., 0].ravel(), turns[..., 1].ravel()
    acts = np.repeat(expressions, views)[:, None] == np.arange(kinds)
    labels = np.column_stack([np.ones(len(yaw)), acts, yaw, pitch, yaw**2, pitch**2, yaw * pitch])
    return SeenFaces(align(points.reshape(-1, COUNT, 2))[0], labels)


def regular_faces(data, rows):
    """The faces that the meshes of a generated Dataset were exaggerated from, drawn again. Returns (N, V, 3)."""
    head, template, place = load_head(), data.template, data.template.region("face")
    actions, shapes = list(read_yaml(asset_path("expressions.yaml")).values()), []
    for row in rows:
        known = {name: float(data.factors[name][row]) for name in ("gender", "age", "weight")}
        changes = data.factors["changes"][row].astype(float).tolist()
        known["changes"] = dict(zip(data.manifest["changes"], changes, strict=True))
        scale, rotation, shift = similarity(head.evaluate(**known)[place], template.vertices[place])
        acting = head.evaluate(**known, actions=expand_sides(actions[data.expression[row]], head.action_names))
        shapes.append(scale * acting @ rotation.T + shift)
    return np.array(shapes)


def has_partners(data):
    """Whether ``regular_faces`` can be drawn for a Dataset."""
    return {"gender", "age", "weight", "changes"} <= set(data.factors) and "changes" in data.manifest


def landmark_error(found, true):
    """Mean distance of landmarks (N, 68, 2) in percent of the diagonal of the true ones, aligned both."""
    diagonals = np.linalg.norm(np.ptp(true, axis=1), axis=1)
    return float(100 * (np.linalg.norm(found - true, axis=2).mean(1) / diagonals).mean())


def measure_landmark_map(landmark_map, pairs, training_pairs):
    """Errors of a map and its rivals on pairs of faces.

    pairs, training_pairs: aligned landmarks (N, 68, 2) by domain; the latter train the linear regression between
    principal components, which no other rival needs.
    Returns dict from the domain mapped to, to errors in percent by rival; and "cycle" by the domain started from.
    """
    codes = {name: landmark_map.domains[name].encode(training_pairs[name]) for name in DOMAINS}
    figures = {}
    for to in DOMAINS:
        given, domain = pairs[other(to)], landmark_map.domains[to]
        regression = np.linalg.lstsq(_with_one(codes[other(to)]), codes[to], rcond=None)[0]
        regressed = domain.decode(_with_one(landmark_map.domains[other(to)].encode(given)) @ regression)
        rivals = {
            "map": landmark_map.map_aligned(given, to),
            "identity": given,
            "mean": np.broadcast_to(domain.mean.reshape(COUNT, 2), given.shape),
            "paired regression": regressed,
        }
        figures[to] = {name: landmark_error(found, pairs[to]) for name, found in rivals.items()}
        figures[to]["below identity"] = 100 * (1 - figures[to]["map"] / figures[to]["identity"])
    return figures


def cycle_errors(landmark_map, faces):
    """Errors in percent of aligned landmarks (N, 68, 2) by domain, there and back."""
    there = {name: landmark_map.map_aligned(seen, other(name)) for name, seen in faces.items()}
    return {name: landmark_error(landmark_map.map_aligned(there[name], name), seen) for name, seen in faces.items()}


def _with_one(codes):
    return np.column_stack([codes, np.ones(len(codes))])


def train_landmark_map(training, unseen, config, seed=0, progress=lambda done, total: None):
    """Train a LandmarkMap without pairs (expressions paper, section 3.2.1).

    Both domains are reduced to principal components. The generators start as a linear map and its inverse (``_start``).
    They and two discriminators then minimise, in turn, ``adversarial`` times least-squares adversarial losses, plus
    ``cycle`` times the mean distance of landmarks that were mapped forth and back, plus ``characteristic`` times one
    minus the cosine between the differences of input and output from the means of their domains. The epoch is kept that
    is best on unseen faces by a measure that needs no pairs.

    training, unseen: SeenFaces by domain. config: LandmarkMapConfig. seed: of all draws. progress: called with finished
    epochs and their total.
    Returns LandmarkMap and a list of dicts, what was measured before training and after every epoch.
    Raises NumericsError when a domain has too few different faces, or a loss is not finite.
    """
    with threadpool_limits(1):
        run, records, best, kept = _Training(training, unseen, config, seed), [], np.inf, None
        for epoch in range(config.epochs + 1):
            if epoch:
                run.epoch(epoch - 1)
            records.append(run.measure())
            if not np.isfinite(records[-1]["criterion"]):
                raise NumericsError(f"the loss of epoch {epoch} is not finite: a smaller learning_rate may help")
            if records[-1]["criterion"] < best:
                best, kept = records[-1]["criterion"], run.generators()
            progress(epoch, config.epochs)
    return LandmarkMap(run.domains, kept), records


def _domain(faces, dimension, seed):
    rows = faces.points.reshape(len(faces.points), -1)
    return Domain(*principal_components(rows, dimension, seed)[:2])


def _start(domains, training, least):
    """The linear map from codes of caricatures to codes of normal faces, (D, D'), to begin with.

    It estimates E[normal | caricature] = caricature C. What labels explain of both codes gives one part of the
    covariance C: a face of either domain with the same labels has the same mean. The remainders of the codes are taken
    to belong together by the turn that moves the landmarks least, and to agree as far as an exaggeration would leave
    them that has nothing to do with the face: as the deviations of the two domains. Singular values below ``least`` are
    raised to it, because the inverse exaggerates by as much.
    """
    normal, caricature = (_explained(domains[name], training[name]) for name in DOMAINS)
    labels = training["caricature"].labels
    shared = (labels @ caricature["effects"]).T @ (labels @ normal["effects"]) / len(labels)
    bases = [domains[name].basis / np.linalg.norm(domains[name].basis, axis=1)[:, None] for name in DOMAINS]
    u, _, vt = np.linalg.svd(caricature["root"] @ bases[1] @ bases[0].T @ normal["root"], full_matrices=False)
    agreement = min(1.0, normal["deviation"] / caricature["deviation"])
    shared += agreement * caricature["root"] @ u @ vt @ normal["root"]
    u, singular, vt = np.linalg.svd(shared, full_matrices=False)
    return (u * np.clip(singular, least, 1 / least)) @ vt


def _explained(domain, faces):
    """Effects (F, D) of labels on codes; root (D, D) of the covariance of what they leave, its size in landmarks."""
    codes = domain.encode(faces.points)
    effects = np.linalg.lstsq(faces.labels, codes, rcond=None)[0]
    rest = codes - faces.labels @ effects
    values, vectors = np.linalg.eigh(rest.T @ rest / len(rest))
    root = (vectors * np.sqrt(np.maximum(values, 0))) @ vectors.T
    return {"effects": effects, "root": root, "deviation": float(np.linalg.norm(root @ domain.basis))}


class _Training:
    """Networks, data and what was learned so far."""

    def __init__(self, training, unseen, config, seed):
        self.config, self.generator = config, torch.Generator().manual_seed(seed)
        self.domains = {name: _domain(training[name], config.dimension, seed) for name in DOMAINS}
        self.bases = {name: torch.from_numpy(self.domains[name].basis).float() for name in DOMAINS}
        self.size = {name: float(self.bases[name].norm()) for name in DOMAINS}
        self.codes, self.unseen = (
            {name: torch.from_numpy(self.domains[name].encode(faces[name].points)).float() for name in DOMAINS}
            for faces in (training, unseen)
        )
        start = _start(self.domains, training, config.least)
        starts = {"normal": start, "caricature": np.linalg.pinv(start)}
        self.networks = {name: self._network(starts[name]) for name in DOMAINS}
        self.judges = {name: _judge(len(self.bases[name]), config.judge_width, self.generator) for name in DOMAINS}
        rate = {"lr": config.learning_rate, "betas": (0.5, 0.999)}
        self.optimiser = torch.optim.Adam([w for net in self.networks.values() for w in net.values()], **rate)
        judging = [weight for judge in self.judges.values() for weight in judge.parameters()]
        self.judge_optimiser = torch.optim.Adam(judging, **rate)

    def _network(self, linear):
        width, (start, end) = self.config.width, linear.shape

        def draw(rows, columns, scale=1.0):
            return scale * (2 / rows) ** 0.5 * torch.randn(rows, columns, generator=self.generator)

        values = torch.from_numpy(linear).float(), draw(start, width), torch.zeros(width), draw(width, width)
        values = *values, torch.zeros(width), draw(width, end, _START), torch.zeros(end)
        return {name: value.requires_grad_() for name, value in zip(WEIGHTS, values, strict=True)}

    def generators(self):
        """The generators' weights as arrays."""
        return {
            name: {key: value.detach().numpy().astype(np.float64) for key, value in net.items()}
            for name, net in self.networks.items()
        }

    def epoch(self, number):
        """Go once through as many faces as the larger domain has."""
        config = self.config
        steps = -(-max(len(codes) for codes in self.codes.values()) // config.batch)
        for step in range(steps):
            # Constant for half of the time, then down to nearly nothing.
            left = 1 - (number + step / steps) / config.epochs
            for group in (*self.optimiser.param_groups, *self.judge_optimiser.param_groups):
                group["lr"] = config.learning_rate * max(_FINAL_RATE, min(1.0, 2 * left))
            real = {name: self._draw(self.codes[name]) for name in DOMAINS}
            fakes = {name: generate(self.networks[name], real[other(name)]) for name in DOMAINS}
            fooling = sum((self.judges[name](fakes[name]) - 1).square().mean() for name in DOMAINS)
            _descend(self.optimiser, config.adversarial * fooling + self._keeping(real, fakes))
            doubts = (
                (judge(real[name]) - 1).square().mean() + judge(fakes[name].detach()).square().mean()
                for name, judge in self.judges.items()
            )
            _descend(self.judge_optimiser, sum(doubts))

    def _draw(self, codes):
        return codes[torch.randint(len(codes), (self.config.batch,), generator=self.generator)]

    def _keeping(self, real, fakes):
        """Cycle and characteristic losses of codes by domain and what they were mapped to, weighted."""
        loss = 0.0
        for name in DOMAINS:
            fake, basis = fakes[other(name)], self.bases[name]
            back = generate(self.networks[name], fake)
            # In units of how much the domain's faces differ.
            cycle = ((back - real[name]) @ basis).norm(dim=1).mean() / self.size[name]
            ways = real[name] @ basis, fake @ self.bases[other(name)]
            turn = 1 - torch.nn.functional.cosine_similarity(*ways, dim=1).mean()
            loss = loss + self.config.cycle * cycle + self.config.characteristic * turn
        return loss

    @torch.no_grad()
    def measure(self):
        """Of unseen faces: how far mapped codes are from real ones as distributions, and what else was minimised."""
        fakes = {name: generate(self.networks[name], self.unseen[other(name)]) for name in DOMAINS}
        distances = {name: _energy_distance(fakes[name], self.unseen[name]) for name in DOMAINS}
        keeping = float(self._keeping(self.unseen, fakes))
        criterion = self.config.adversarial * sum(distances.values()) + keeping
        return {"criterion": criterion, "energy_distance": distances, "cycle and characteristic": keeping}


def _descend(optimiser, loss):
    optimiser.zero_grad()
    loss.backward()
    optimiser.step()


def _judge(dimension, width, generator):
    """A discriminator of codes."""
    layers = [torch.nn.Linear(a, b) for a, b in ((dimension, width), (width, width), (width, 1))]
    for layer in layers:
        torch.nn.init.kaiming_normal_(layer.weight, generator=generator)
        torch.nn.init.zeros_(layer.bias)
    return torch.nn.Sequential(layers[0], torch.nn.LeakyReLU(0.2), layers[1], torch.nn.LeakyReLU(0.2), layers[2])


def _energy_distance(first, second):
    """Between two samples (N, D) and (M, D)."""
    first, second = (rows[:: -(-len(rows) // _COMPARED)] for rows in (first, second))
    within = (torch.cdist(rows, rows).sum() / max(1, len(rows) * (len(rows) - 1)) for rows in (first, second))
    return float(2 * torch.cdist(first, second).mean() - sum(within))
