"""Latents and a network that turns them into shapes, trained together (deformable paper, section 3.3)."""

from dataclasses import dataclass
from math import cos, pi

import igl
import numpy as np
import torch

from caricli.errors import NumericsError
from caricli.models.principal_components import principal_components

_WARM_UP = 100  # steps, of a training at least twenty times as long
_FINAL_RATE = 0.01
_VALIDATION_RATE = 0.05
_PRIOR_CODES, _ROUGH_VERTICES = 8, 64
_ORDER, _STEP, _VALIDATION = range(3)


@dataclass(frozen=True)
class Points:
    """Places on the template's surface: corners (n, 3) vertex ids, weights (n, 3), positions (n, 3) in [-1, 1]."""

    corners: torch.Tensor
    weights: torch.Tensor
    positions: torch.Tensor

    def values(self, fields):
        """Interpolate what is known at the vertices. fields: (..., V, 3). Returns (..., n, 3)."""
        return (fields[..., self.corners, :] * self.weights[:, :, None]).sum(-2)


class Surface:
    """The network's template, in its own coordinates, and places drawn on it."""

    def __init__(self, frame, faces, device="cpu"):
        """frame: Frame. faces: (F, 3)."""
        self.frame = frame
        self.vertices = torch.from_numpy(frame.normalise(frame.points).astype(np.float32)).to(device)
        self.faces = torch.from_numpy(np.asarray(faces, dtype=np.int64)).to(device)
        areas = igl.doublearea(np.asarray(frame.points, dtype=np.float64), np.asarray(faces))
        self.areas = areas / areas.sum()

    def at_vertices(self, ids):
        """Points at vertices. ids: (n,)."""
        ids = torch.as_tensor(ids, device=self.vertices.device)
        weights = torch.zeros(len(ids), 3, device=ids.device)
        weights[:, 0] = 1
        return Points(ids[:, None].expand(-1, 3), weights, self.vertices[ids])

    def draw(self, count, vertex_share, generator):
        """Draw vertices without repetition and uniform points of the surface (supplement 2).

        count: of points in all. generator: numpy Generator. Returns Points.
        """
        at_vertices = min(round(count * vertex_share), len(self.vertices))
        ids = generator.permutation(len(self.vertices))[:at_vertices]
        triangles = generator.choice(len(self.faces), count - at_vertices, p=self.areas)
        weights = generator.dirichlet(np.ones(3), count - at_vertices).astype(np.float32)
        first = self.at_vertices(ids)
        corners = torch.cat([first.corners, self.faces[torch.from_numpy(triangles).to(self.faces.device)]])
        weights = torch.cat([first.weights, torch.from_numpy(weights).to(self.faces.device)])
        return Points(corners, weights, (self.vertices[corners] * weights[:, :, None]).sum(-2))

    def displacements(self, shapes):
        """Shapes (N, V, 3) metres to displacements in the network's coordinates, a tensor."""
        moved = (np.asarray(shapes) - self.frame.points) * self.frame.scale
        return torch.from_numpy(moved.astype(np.float32)).to(self.vertices.device)


@dataclass(frozen=True)
class EpochRecord:
    """What an epoch came to: mean loss; mean distance of points, in metres, of training and of unseen meshes."""

    epoch: int
    loss: float
    train_error: float
    validation_error: float | None
    best: bool


class AutoDecoderTraining:
    """Training that can stop after any epoch and go on from ``state()`` as if it had not.

    Minimises, over the network and one latent per training mesh, with points drawn anew every step,
    ``data_weight mean |d_i - S(p_i; z_k)|^2 + latent_weight / M |z_k|^2`` (equation 1) plus
    ``prior_weight / M |C - I|^2`` with C the second moments of all latents over latent_std^2, plus
    ``smoothness_weight`` times the roughness of displacements, compared with that of the training shapes, at latents
    drawn from that prior. Of ``mixup`` of the shapes mixtures take their place, of latents and of displacements alike
    (Zhang et al. 2018), so that also the shapes between are what they should be.

    Every draw comes from (seed, epoch, step), so nothing but weights, moments and counters has to be kept. With several
    processes each takes its share of every batch, and gradients are summed.
    """

    def __init__(self, network, surface, shapes, unseen, config, process=0, processes=1):
        """network: module(latents, Points) -> displacements. surface: Surface. shapes (N, V, 3), unseen (U, V, 3)."""
        self.network, self.surface, self.config = network, surface, config
        self.process, self.processes = process, processes
        self.shapes, self.unseen = surface.displacements(shapes), surface.displacements(unseen)
        self.epoch, self.best, self.since_best = 0, float("inf"), 0
        device, self.mean = self.shapes.device, self.shapes.mean(0)
        start, unseen_start = _start(shapes, unseen, config)
        self.latents = torch.nn.Parameter(torch.from_numpy(start).to(device))
        self.codes = torch.nn.Parameter(torch.from_numpy(unseen_start).to(device))
        rates = [
            {"params": list(network.parameters()), "lr": config.learning_rate},
            {"params": [self.latents], "lr": config.latent_rate * config.latent_std},
        ]
        self.optimiser = torch.optim.Adam(rates, fused=True)
        self.code_optimiser = torch.optim.Adam([self.codes], lr=_VALIDATION_RATE * config.latent_std)
        self.roughness = _Roughness(surface, self.shapes) if config.smoothness_weight else None

    def state(self):
        """Everything that the rest of the training depends on, for torch.save."""
        return {
            "network": self.network.state_dict(),
            "latents": self.latents.data,
            "codes": self.codes.data,
            "optimiser": self.optimiser.state_dict(),
            "code_optimiser": self.code_optimiser.state_dict(),
            "counters": [self.epoch, self.best, self.since_best],
        }

    def load_state(self, state):
        """Go on from a state."""
        self.network.load_state_dict(state["network"])
        self.latents.data.copy_(state["latents"])
        self.codes.data.copy_(state["codes"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.code_optimiser.load_state_dict(state["code_optimiser"])
        self.epoch, self.best, self.since_best = state["counters"]

    @property
    def ended(self):
        """Whether all epochs are done, or validation has not improved for too long."""
        impatient = 0 < self.config.patience <= self.since_best
        return impatient or self.epoch >= self.config.epochs

    def epochs(self):
        """Train and yield an EpochRecord after every epoch. Raises NumericsError when the loss is not finite."""
        config = self.config
        while not self.ended:
            loss, error = self._train_epoch()
            self.epoch += 1
            validation, best = None, False
            if self.epoch % config.validate_every == 0 or self.epoch == config.epochs:
                validation = self._validate() if len(self.unseen) else error
                best = validation < self.best
                self.best, self.since_best = (validation, 0) if best else (self.best, self.since_best + 1)
            yield EpochRecord(self.epoch, loss, error, validation, best)

    def _train_epoch(self):
        config, count = self.config, len(self.shapes)
        batch = min(config.batch, count)
        order = self._generator(_ORDER).permutation(count)
        steps = count // batch
        sums = torch.zeros(2)
        for step in range(steps):
            self._set_rate(self.epoch * steps + step, config.epochs * steps)
            sums += self._step(torch.from_numpy(order[step * batch : (step + 1) * batch]), step)
        loss, error = (sums / steps).tolist()
        return loss, error / self.surface.frame.scale

    def _step(self, rows, step):
        config, generator = self.config, self._generator(_STEP, step)
        noise = torch.from_numpy(generator.normal(size=(len(rows), config.latent)).astype(np.float32))
        points = self.surface.draw(config.points, config.vertex_share, generator)
        drawn = torch.from_numpy(generator.normal(size=(_PRIOR_CODES, config.latent)).astype(np.float32))
        mine = slice(self.process, None, self.processes)
        device, share = self.latents.device, 1 / len(rows)
        mine_rows = rows[mine].to(device)
        angles = np.pi / 2 * generator.uniform(size=len(rows)) * (generator.uniform(size=len(rows)) < config.mixup)
        angles = torch.from_numpy(angles.astype(np.float32))[mine].to(device)
        mixed, aims = self._mixtures(mine_rows, rows.roll(1)[mine].to(device), angles, points)
        mixed = mixed + config.noise * config.latent_std * noise[mine].to(device)
        squares = (self.network(mixed, points) - aims).square().sum(-1)
        data = share * squares.mean(1).sum()
        loss = config.data_weight * data + config.latent_weight * share * self.latents[mine_rows].square().mean(1).sum()
        if config.prior_weight:
            loss = loss + config.prior_weight * self._prior_loss() / self.processes
        if self.roughness:
            rough = self.roughness(self.network, config.latent_std * drawn.to(device), generator)
            loss = loss + config.smoothness_weight * rough / self.processes
        self.optimiser.zero_grad()
        loss.backward()
        figures = torch.stack([loss.detach(), share * squares.detach().sqrt().mean(1).sum()]).cpu()
        if self.processes > 1:
            figures = self._sum_over_processes(figures)
        if not torch.isfinite(figures).all():
            raise NumericsError(f"the loss of epoch {self.epoch + 1} is not finite: a smaller learning_rate may help")
        self.optimiser.step()
        return figures

    def _mixtures(self, rows, others, angles, points):
        """Latents (B, D) and displacements (B, n, 3) of mixtures of two shapes, at angles (B,) between them.

        Their differences from the mean are weighted by cosine and sine, so that mixtures are as far from it as they.
        """
        first, second = torch.cos(angles)[:, None], torch.sin(angles)[:, None]
        latents = first * self.latents[rows] + second * self.latents[others]
        first, second = first[:, :, None], second[:, :, None]
        aims = first * points.values(self.shapes[rows]) + second * points.values(self.shapes[others])
        return latents, aims + (1 - first - second) * points.values(self.mean)

    def _squares(self, latents, points, displacements):
        """(B, n) squared distances of the network's points from those of the shapes."""
        return (self.network(latents, points) - points.values(displacements)).square().sum(-1)

    def _prior_loss(self):
        spread = self.latents / self.config.latent_std
        moments = spread.mT @ spread / len(spread) - torch.eye(self.config.latent, device=spread.device)
        return (moments.square().sum() + spread.mean(0).square().sum()) / self.config.latent

    def _validate(self):
        """Improve the codes of unseen meshes by a few steps and return their error."""
        config = self.config
        for parameter in self.network.parameters():
            parameter.requires_grad_(False)
        for step in range(config.validation_steps):
            points = self.surface.draw(config.points, config.vertex_share, self._generator(_VALIDATION, step))
            squares = self._squares(self.codes, points, self.unseen)
            loss = config.data_weight * squares.mean() + config.latent_weight * self.codes.square().mean()
            self.code_optimiser.zero_grad()
            loss.backward()
            self.code_optimiser.step()
        everywhere = self.surface.at_vertices(np.arange(len(self.surface.vertices)))
        with torch.no_grad():
            errors = [
                self._squares(code[None], everywhere, shape[None]).sqrt().mean()
                for code, shape in zip(self.codes, self.unseen, strict=True)
            ]
        for parameter in self.network.parameters():
            parameter.requires_grad_(True)
        return float(torch.stack(errors).mean()) / self.surface.frame.scale

    def _set_rate(self, step, total):
        config = self.config
        factor = min(1.0, (step + 1) / min(_WARM_UP, 1 + total // 20))
        if config.schedule == "cosine":
            factor *= _FINAL_RATE + (1 - _FINAL_RATE) * 0.5 * (1 + cos(pi * step / total))
        rates = config.learning_rate, config.latent_rate * config.latent_std
        for group, rate in zip(self.optimiser.param_groups, rates, strict=True):
            group["lr"] = factor * rate

    def _generator(self, purpose, step=0):
        return np.random.default_rng([self.config.seed, purpose, self.epoch, step])

    def _sum_over_processes(self, figures):
        for parameter in [*self.network.parameters(), self.latents]:
            torch.distributed.all_reduce(parameter.grad)
        device_figures = figures.to(self.latents.device)
        torch.distributed.all_reduce(device_figures)
        return device_figures.cpu()


class _Roughness:
    """How much farther displacements are from the mean of their neighbours' than in the training shapes."""

    def __init__(self, surface, shapes):
        neighbours = igl.adjacency_list(surface.faces.cpu().numpy())
        width = max(len(ring) for ring in neighbours)
        # Short rings are filled up with the vertex itself, at no weight.
        rings = [[*ring, *[k] * (width - len(ring))] for k, ring in enumerate(neighbours)]
        weights = [[*[1 / len(ring)] * len(ring), *[0.0] * (width - len(ring))] for ring in neighbours]
        device = surface.vertices.device
        self.surface, self.rings = surface, torch.tensor(rings, device=device)
        self.weights = torch.tensor(weights, device=device)
        squares = torch.zeros(len(rings), device=device)
        for shape in shapes:
            squares += self._laplacians(shape, shape[self.rings], self.weights).square().sum(-1)
        self.usual = (squares / len(shapes)).sqrt() + 1e-6

    def __call__(self, network, latents, generator):
        chosen = generator.choice(len(self.rings), min(_ROUGH_VERTICES, len(self.rings)), replace=False)
        chosen = torch.from_numpy(chosen).to(latents.device)
        ids = torch.cat([chosen[:, None], self.rings[chosen]], dim=1)
        fields = network(latents, self.surface.at_vertices(ids.flatten())).unflatten(1, ids.shape)
        rough = self._laplacians(fields[:, :, 0], fields[:, :, 1:], self.weights[chosen]).norm(dim=-1)
        return (rough / self.usual[chosen]).square().mean()

    @staticmethod
    def _laplacians(centres, rings, weights):
        return centres - (rings * weights[..., None]).sum(-2)


def _start(shapes, unseen, config):
    """Latents to begin with: draws, or whitened projections on principal components filled up with draws."""
    generator = np.random.default_rng([config.seed, 3])
    latents = generator.normal(size=(len(shapes), config.latent))
    codes = np.zeros((len(unseen), config.latent))
    if config.start == "principal":
        rows = np.asarray(shapes).reshape(len(shapes), -1)
        mean, basis, _ = principal_components(rows, config.latent, config.seed)
        encoder = basis / np.square(basis).sum(1, keepdims=True)
        latents[:, : len(basis)] = (rows - mean) @ encoder.T
        codes[:, : len(basis)] = (np.asarray(unseen).reshape(len(unseen), -1) - mean) @ encoder.T
    return (latents * config.latent_std).astype(np.float32), (codes * config.latent_std).astype(np.float32)
