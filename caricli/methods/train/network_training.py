"""What trainings of networks on windows of pictures have in common."""

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from math import cos, pi
from typing import Any

import torch

from caricli.errors import InputError, NumericsError
from caricli.methods.train.kernel_muon import KernelMuon
from caricli.methods.train.processes import Share
from caricli.methods.train.require_like import optimiser_form, require_like
from caricli.methods.train.stages import EpochRecord

WARM_UP = 200
"""Steps in which the learning rate rises, of a training at least ``WARM_UP_SHARE`` times as long."""

WARM_UP_SHARE = 20
"""At most one in so many steps is for warming up."""

STEEPEST = 5.0
"""Length to which gradients are cut."""


class NetworkTraining(ABC):
    """Training of a network in steps that can stop after any epoch and go on from ``state()`` as if it had not.

    What is kept is the moving average of the weights. Every draw comes from (seed, epoch, step, window), so nothing but
    weights, moments and counters has to be kept. With several processes each takes its share of every batch, and
    gradients are summed, weighted by how many windows it took; normalisation is over the share.
    """

    def __init__(self, make: Callable[[torch.Generator], Any], config: Any, share: Share) -> None:
        """make: a network with random weights.

        config: with ``epochs``, ``steps`` of one, ``batch``, ``learning_rate`` and ``weight_decay`` of AdamW, ``decay``
        of the average, ``validate_every`` and ``seed``.
        Raises InputError when there are more processes than a batch has windows of a kind.
        """
        self.config = config
        self.share = share
        for kind, count in self._needed().items():
            if share.count > count:
                raise InputError(f"expected a batch with one for each of {share.count} processes, found {count} {kind}")
        self.epoch = 0
        self.best = float("inf")
        generator = torch.Generator().manual_seed(config.seed)
        self.network = make(generator)
        self.average = make(generator)
        self.average.load_state_dict(self.network.state_dict())
        self._optimise()

    def _needed(self) -> dict[str, int]:
        """How many windows of a batch are of every kind, by its name, of which each process must have one."""
        return {"windows": self.config.batch}

    @property
    def _shares(self) -> float:
        """How many times what this process takes of a batch makes a whole one."""
        return self.config.batch / len(self.share.rows(self.config.batch))

    def _kernels(self) -> Sequence[torch.Tensor]:
        """The weights that learn by Muon, at the configured ``kernel_rate``."""
        return ()

    def _optimise(self) -> None:
        """Let the network learn from here on: kernels by Muon, all else by AdamW."""
        config = self.config
        kernels = self._kernels()
        by_muon = {id(kernel) for kernel in kernels}
        others = [parameter for parameter in learned_by(self.network) if id(parameter) not in by_muon]
        self.optimiser = torch.optim.AdamW(
            others, lr=config.learning_rate, weight_decay=config.weight_decay, fused=True
        )
        self.muon = KernelMuon(kernels, config.kernel_rate, config.weight_decay) if kernels else None

    @abstractmethod
    def _draw(self, step: int) -> Any:
        """This process's windows of a step."""

    @abstractmethod
    def _loss(self, drawn: Any) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of windows, and an error that is logged beside it."""

    @abstractmethod
    def _validate(self) -> float:
        """The error of the average on what it has not seen."""

    @property
    def ended(self) -> bool:
        """Whether all epochs are done."""
        return self.epoch >= self.config.epochs

    @property
    def validates(self) -> bool:
        """Whether the network is far enough to be validated."""
        return True

    def copied_average(self) -> Any:
        """What is kept of the training, as a network of its own."""
        return copy.deepcopy(self.average)

    def state(self) -> dict:
        """Everything that the rest of the training depends on, for torch.save."""
        states = {name: part.state_dict() for name, part in self._parts().items()}
        return states | {"counters": [self.epoch, self.best]}

    def _parts(self) -> dict[str, Any]:
        """Networks and optimisers whose state is kept, by name."""
        parts = {"network": self.network, "average": self.average, "optimiser": self.optimiser}
        return parts if self.muon is None else parts | {"muon": self.muon}

    def load_state(self, state: dict) -> None:
        """Go on from a state that ``state()`` gave. Raises InputError when it is of another training."""
        own = self._parts()
        optimisers = {name: part for name, part in own.items() if isinstance(part, torch.optim.Optimizer)}
        form = self.state() | {name: optimiser_form(each, state.get(name)) for name, each in optimisers.items()}
        require_like({name: state.get(name) for name in form}, form)
        for name, part in own.items():
            part.load_state_dict(state[name])
        self.epoch, self.best = state["counters"]

    def epochs(self) -> Iterator[EpochRecord]:
        """Train, and yield what came of it after every epoch. Raises NumericsError when the loss is not finite."""
        config = self.config
        # Under deterministic algorithms PyTorch would fill all memory that it takes before it is written.
        torch.utils.deterministic.fill_uninitialized_memory = False  # type: ignore[attr-defined]
        while not self.ended:
            loss, error = self._train_epoch()
            self.epoch += 1
            validation = None
            best = False
            if self.validates and (self.epoch % config.validate_every == 0 or self.ended):
                validation = self._validate()
                best = validation < self.best
                self.best = min(validation, self.best)
            yield EpochRecord(self.epoch, loss, error, validation, best)

    def _train_epoch(self) -> tuple[float, float]:
        self.network.train()
        sums: Any = 0.0
        with ThreadPoolExecutor(1) as drawer:
            # The windows of the next step are drawn while this one is taken.
            next_draw = drawer.submit(self._draw, 0)
            for step in range(self.config.steps):
                drawn = next_draw.result()
                if step + 1 < self.config.steps:
                    next_draw = drawer.submit(self._draw, step + 1)
                self._set_rate(self.epoch * self.config.steps + step)
                sums = sums + self._step(step, drawn)
        if not torch.isfinite(sums).all():
            raise NumericsError(f"the loss of epoch {self.epoch + 1} is not finite: a smaller learning_rate may help")
        if self.share.count > 1:
            self._share_buffers()
        loss, error = (sums / self.config.steps).tolist()
        return loss, error

    def _step(self, step: int, drawn: Any) -> torch.Tensor:
        """Go one step down, on windows of ``_draw``. Returns loss and error, of all processes together."""
        loss, error = self._loss(drawn)
        figures = torch.stack([loss.detach(), error]) / self._shares
        if self.share.count > 1:
            torch.distributed.all_reduce(figures)
        self._descend(self.network, loss, self.optimiser, self.muon)
        self._follow(self.epoch * self.config.steps + step)
        return figures

    def _descend(self, network: torch.nn.Module, loss: torch.Tensor, *optimisers: torch.optim.Optimizer | None) -> None:
        """Go one step of a network's optimisers down a loss, of which every process has its share."""
        network.zero_grad()
        (loss / self._shares).backward()
        learned = learned_by(network)
        if self.share.count > 1:
            sum_gradients(learned)
        torch.nn.utils.clip_grad_norm_(learned, STEEPEST)
        for optimiser in filter(None, optimisers):
            optimiser.step()

    @torch.no_grad()
    def _follow(self, step: int) -> None:
        """Let the average follow the weights: of the first steps quickly, because it starts where they did."""
        decay = min(self.config.decay, (1 + step) / (10 + step))
        for own, value in zip(self.average.state_dict().values(), self.network.state_dict().values(), strict=True):
            if own.is_floating_point():
                own.lerp_(value, 1 - decay)
            else:
                own.copy_(value)

    def _set_rate(self, step: int) -> None:
        self._schedule(step, self.config.epochs * self.config.steps, self.config.learning_rate)

    def _schedule(self, step: int, total: int, rate: float) -> None:
        """Set the learning rate of a step of ``total``, ``rate`` at most: it rises shortly and falls as a cosine.

        Muon's is as much of ``kernel_rate`` as it is of ``learning_rate``.
        """
        factor = min(1.0, (step + 1) / min(WARM_UP, 1 + total // WARM_UP_SHARE))
        own = rate * factor * 0.5 * (1 + cos(pi * step / total))
        for group in self.optimiser.param_groups:
            group["lr"] = own
        if self.muon is not None:
            for group in self.muon.param_groups:
                group["lr"] = own / self.config.learning_rate * self.config.kernel_rate

    def _share_buffers(self) -> None:
        """Let all processes have the same statistics of normalisation, their mean: that of the first is stored."""
        for network in (self.network, self.average):
            for buffer in network.buffers():
                if buffer.is_floating_point():
                    torch.distributed.all_reduce(buffer)
                    buffer /= self.share.count


def learned_by(network: torch.nn.Module) -> list[torch.nn.Parameter]:
    """The parameters that a network learns."""
    return [parameter for parameter in network.parameters() if parameter.requires_grad]


def sum_gradients(parameters: Sequence[torch.nn.Parameter]) -> None:
    """Give every process the sum of all processes' gradients, in one piece: each sum waits for the slowest."""
    # A process may have had nothing for a parameter.
    gradients = [torch.zeros_like(each) if each.grad is None else each.grad for each in parameters]
    together = torch.cat([gradient.flatten() for gradient in gradients])
    torch.distributed.all_reduce(together)
    parts = together.split([each.numel() for each in parameters])
    for parameter, gradient, part in zip(parameters, gradients, parts, strict=True):
        parameter.grad = gradient.copy_(part.view_as(gradient))


def require_faces(training: Any, unseen: Any) -> None:
    """Refuse pictures to train and to validate on of which one has no ``faces``. Raises InputError."""
    for name, pictures in (("train", training), ("validate", unseen)):
        if not len(pictures.faces):
            raise InputError(f"expected pictures with faces to {name} on, found none")
