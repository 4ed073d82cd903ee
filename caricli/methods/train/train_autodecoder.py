"""Latents and a network that turns them into shapes, trained together (deformable paper, section 3.3)."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, pi

import numpy as np
import torch

from caricli.errors import NumericsError
from caricli.methods.train.deformable.code_fit import CodeFit, square_distances
from caricli.methods.train.deformable.roughness import Roughness
from caricli.methods.train.deformable.surface import Points, TrainingMeshes
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.require_like import optimiser_form, require_like
from caricli.methods.train.stages import EpochRecord
from caricli.models.deformable.config import DeformableConfig
from caricli.models.principal_components import principal_components
from caricli.seeds import TrainingSeed

WARM_UP = 100
"""Steps in which the learning rate rises, of a training at least ``WARM_UP_SHARE`` times as long."""

WARM_UP_SHARE = 20
"""At most one in so many steps is for warming up."""

FINAL_RATE = 0.01
"""Learning rate at the end of the cosine schedule, a share of the highest."""

VALIDATION_RATE = 0.05
"""Learning rate of the unseen meshes' codes, in units of latent_std: they must follow a network that changes."""

PRIOR_CODES = 8
"""Latents drawn from the prior a step, where roughness is measured."""


@dataclass(frozen=True, eq=False)
class _Draws:
    """Random in a step: noise (B, D), points on the template, latents of the prior (P, D), angles (B,) of mixtures."""

    noise: torch.Tensor
    points: Points
    prior: torch.Tensor
    angles: torch.Tensor


class AutoDecoderTraining:
    """Training that can stop after any epoch and go on from ``state()`` as if it had not.

    Minimises, over the network and one latent per training mesh, with points drawn anew every step,
    ``data_weight mean |d_i - S(p_i; z_k)|^2 + latent_weight / M |z_k|^2`` (equation 1) plus
    ``prior_weight / M (|C - I|^2 + |m|^2)`` with m and C mean and second moments of all latents over latent_std, plus
    ``smoothness_weight`` times the roughness of displacements, compared with that of the training shapes, at latents
    drawn from that prior. Of ``mixup`` of the shapes mixtures take their place, of latents and of displacements alike
    (Zhang et al. 2018), so that also the shapes between are what they should be.

    Every draw comes from (seed, epoch, step), so nothing but weights, moments and counters has to be kept. With several
    processes each takes its share of every batch, and gradients are summed.
    """

    def __init__(
        self, network: torch.nn.Module, meshes: TrainingMeshes, config: DeformableConfig, share: Share = ALL
    ) -> None:
        """network: module(latents, Points) -> displacements."""
        self.network = network
        self.surface = meshes.surface
        self.config = config
        self.share = share
        self.shapes = self.surface.displacements(meshes.shapes)
        self.unseen = self.surface.displacements(meshes.unseen)
        self.mean = self.shapes.mean(0)
        self.epoch = 0
        self.best = float("inf")
        self.since_best = 0
        device = self.shapes.device
        start, unseen_start = _start(meshes, config)
        self.latents = torch.nn.Parameter(torch.from_numpy(start).to(device))
        self.code_fit = CodeFit(torch.from_numpy(unseen_start).to(device), VALIDATION_RATE, config)
        rates = [
            {"params": list(network.parameters()), "lr": config.learning_rate},
            {"params": [self.latents], "lr": config.latent_rate * config.latent_std},
        ]
        self.optimiser = torch.optim.Adam(rates, fused=True)
        self.roughness = Roughness(self.surface, self.shapes) if config.smoothness_weight else None

    @property
    def codes(self) -> torch.Tensor:
        """(U, D) latents of the unseen meshes, as of the last validation."""
        return self.code_fit.codes

    def state(self) -> dict:
        """Everything that the rest of the training depends on, for torch.save."""
        return {
            "network": self.network.state_dict(),
            "latents": self.latents.data,
            "codes": self.codes.data,
            "optimiser": self.optimiser.state_dict(),
            "code_optimiser": self.code_fit.optimiser.state_dict(),
            "counters": [self.epoch, self.best, self.since_best],
        }

    def load_state(self, state: dict) -> None:
        """Go on from a state that ``state()`` gave. Raises InputError when it is of another training."""
        optimisers = {"optimiser": self.optimiser, "code_optimiser": self.code_fit.optimiser}
        require_like(
            {name: state.get(name) for name in self.state()},
            self.state() | {name: optimiser_form(each, state.get(name)) for name, each in optimisers.items()},
        )
        self.network.load_state_dict(state["network"])
        self.latents.data.copy_(state["latents"])
        self.codes.data.copy_(state["codes"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.code_fit.optimiser.load_state_dict(state["code_optimiser"])
        self.epoch, self.best, self.since_best = state["counters"]

    @property
    def ended(self) -> bool:
        """Whether all epochs are done, or validation has not improved for too long."""
        impatient = 0 < self.config.patience <= self.since_best
        return impatient or self.epoch >= self.config.epochs

    def epochs(self) -> Iterator[EpochRecord]:
        """Train, and yield what came of it after every epoch. Raises NumericsError when the loss is not finite."""
        config = self.config
        while not self.ended:
            loss, error = self._train_epoch()
            self.epoch += 1
            validation = None
            best = False
            if self.epoch % config.validate_every == 0 or self.epoch == config.epochs:
                validation = self._validate() if len(self.unseen) else error
                best = validation < self.best
                self.since_best = 0 if best else self.since_best + 1
                self.best = validation if best else self.best
            yield EpochRecord(self.epoch, loss, error, validation, best)

    def _train_epoch(self) -> tuple[float, float]:
        """Mean loss, and mean distance of points in metres."""
        config = self.config
        count = len(self.shapes)
        batch = min(config.batch, count)
        order = self._generator(TrainingSeed.ORDER).permutation(count)
        steps = count // batch
        sums = torch.zeros(2)
        for step in range(steps):
            self._set_rate(self.epoch * steps + step, config.epochs * steps)
            sums += self._step(torch.from_numpy(order[step * batch : (step + 1) * batch]), step)
        loss, error = (sums / steps).tolist()
        return loss, error / self.surface.box.scale

    def _step(self, rows: torch.Tensor, step: int) -> torch.Tensor:
        """Go one step down on a batch of meshes (B,). Returns loss and mean distance, of all processes together."""
        loss, distance = self._loss(rows, self._generator(TrainingSeed.STEP, step))
        self.optimiser.zero_grad()
        loss.backward()
        figures = torch.stack([loss.detach(), distance]).cpu()
        if self.share.count > 1:
            figures = self._sum_over_processes(figures)
        if not torch.isfinite(figures).all():
            raise NumericsError(f"the loss of epoch {self.epoch + 1} is not finite: a smaller learning_rate may help")
        self.optimiser.step()
        return figures

    def _loss(self, rows: torch.Tensor, generator: np.random.Generator) -> tuple[torch.Tensor, torch.Tensor]:
        """This process's share of the loss of a batch (B,), and of its mean distance, which has no gradient."""
        config = self.config
        draws = self._draw(len(rows), generator)
        mine = slice(self.share.process, None, self.share.count)
        share = 1 / len(rows)
        device = self.latents.device
        own = rows[mine].to(device)
        others = rows.roll(1)[mine].to(device)
        mixed, aims = self._mixtures(own, others, draws.angles[mine].to(device), draws.points)
        mixed = mixed + config.noise * config.latent_std * draws.noise[mine].to(device)
        squares = (self.network(mixed, draws.points) - aims).square().sum(-1)
        data = share * squares.mean(1).sum()
        loss = config.data_weight * data + config.latent_weight * share * self.latents[own].square().mean(1).sum()
        if config.prior_weight:
            loss = loss + config.prior_weight * self._prior_loss() / self.share.count
        if self.roughness:
            rough = self.roughness(self.network, config.latent_std * draws.prior.to(device), generator)
            loss = loss + config.smoothness_weight * rough / self.share.count
        return loss, share * squares.detach().sqrt().mean(1).sum()

    def _draw(self, count: int, generator: np.random.Generator) -> "_Draws":
        """What is random in a step on so many meshes."""
        config = self.config
        noise = generator.normal(size=(count, config.latent))
        points = self.surface.draw(config.points, config.vertex_share, generator)
        prior = generator.normal(size=(PRIOR_CODES, config.latent))
        angles = np.pi / 2 * generator.uniform(size=count) * (generator.uniform(size=count) < config.mixup)
        return _Draws(_single(noise), points, _single(prior), _single(angles))

    def _mixtures(
        self, rows: torch.Tensor, others: torch.Tensor, angles: torch.Tensor, points: Points
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Latents (B, D) and displacements (B, n, 3) of mixtures of two shapes, at angles (B,) between them.

        Their differences from the mean are weighted by cosine and sine, so that mixtures are as far from it as they.
        """
        cosine = torch.cos(angles)[:, None]
        sine = torch.sin(angles)[:, None]
        latents = cosine * self.latents[rows] + sine * self.latents[others]
        cosine = cosine[:, :, None]
        sine = sine[:, :, None]
        aims = cosine * points.values(self.shapes[rows]) + sine * points.values(self.shapes[others])
        return latents, aims + (1 - cosine - sine) * points.values(self.mean)

    def _prior_loss(self) -> torch.Tensor:
        """How far the mean of all latents is from 0, and their second moments from latent_std^2."""
        spread = self.latents / self.config.latent_std
        moments = spread.mT @ spread / len(spread) - torch.eye(self.config.latent, device=spread.device)
        return (moments.square().sum() + spread.mean(0).square().sum()) / self.config.latent

    def _validate(self) -> float:
        """Improve the codes of unseen meshes by a few steps and return their error in metres."""
        config = self.config
        for parameter in self.network.parameters():
            parameter.requires_grad_(False)
        for step in range(config.validation_steps):
            generator = self._generator(TrainingSeed.VALIDATION, step)
            points = self.surface.draw(config.points, config.vertex_share, generator)
            self.code_fit.step(self.network, points, self.unseen)
        everywhere = self.surface.at_vertices()
        with torch.no_grad():
            errors = [
                square_distances(self.network, code[None], everywhere, shape[None]).sqrt().mean()
                for code, shape in zip(self.codes, self.unseen, strict=True)
            ]
        for parameter in self.network.parameters():
            parameter.requires_grad_(True)
        return float(torch.stack(errors).mean()) / self.surface.box.scale

    def _set_rate(self, step: int, total: int) -> None:
        config = self.config
        factor = min(1.0, (step + 1) / min(WARM_UP, 1 + total // WARM_UP_SHARE))
        if config.schedule == "cosine":
            factor *= FINAL_RATE + (1 - FINAL_RATE) * 0.5 * (1 + cos(pi * step / total))
        rates = (config.learning_rate, config.latent_rate * config.latent_std)
        for group, rate in zip(self.optimiser.param_groups, rates, strict=True):
            group["lr"] = factor * rate

    def _generator(self, purpose: TrainingSeed, step: int = 0) -> np.random.Generator:
        return np.random.default_rng([self.config.seed, purpose, self.epoch, step])

    def _sum_over_processes(self, figures: torch.Tensor) -> torch.Tensor:
        for parameter in [*self.network.parameters(), self.latents]:
            torch.distributed.all_reduce(parameter.grad)
        device_figures = figures.to(self.latents.device)
        torch.distributed.all_reduce(device_figures)
        return device_figures.cpu()


def _single(values: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(values.astype(np.float32))


def _start(meshes: TrainingMeshes, config: DeformableConfig) -> tuple[np.ndarray, np.ndarray]:
    """Latents (N, D) and codes (U, D) to begin with.

    Either draws, or whitened projections on principal components filled up with draws.
    """
    generator = np.random.default_rng([config.seed, TrainingSeed.START])
    shapes = np.asarray(meshes.shapes).reshape(len(meshes.shapes), -1)
    unseen = np.asarray(meshes.unseen).reshape(len(meshes.unseen), shapes.shape[1])
    latents = generator.normal(size=(len(shapes), config.latent))
    codes = np.zeros((len(unseen), config.latent))
    if config.start == "principal":
        mean, basis, _ = principal_components(shapes, config.latent, config.seed)
        encoder = basis / np.square(basis).sum(1, keepdims=True)
        latents[:, : len(basis)] = (shapes - mean) @ encoder.T
        codes[:, : len(basis)] = (unseen - mean) @ encoder.T
    return (latents * config.latent_std).astype(np.float32), (codes * config.latent_std).astype(np.float32)
