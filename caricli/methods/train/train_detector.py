"""A detector, trained on pictures whose truth is known."""

import copy
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from math import cos, pi
from typing import Protocol

import numpy as np
import torch

from caricli.errors import InputError, NumericsError
from caricli.methods.train.detector_losses import FaceTargets, face_loss, landmark_loss, region_loss
from caricli.methods.train.disguise_picture import disguise_window
from caricli.methods.train.require_like import adam_form, require_like
from caricli.methods.train.train_autodecoder import ALL, EpochRecord, Share
from caricli.methods.train.windows import WindowSettings, any_window, face_window
from caricli.models.detector.config import DetectorConfig
from caricli.models.detector.networks import FINE, DetectorNetwork
from caricli.render.cut_window import cut_window
from caricli.seeds import TrainingSeed
from caricli.structures.detection import FaceFrame, MarkedPicture
from caricli.structures.landmarks import COUNT, SCHEMES
from caricli.structures.parsing import Region

LANDMARKS = max(SCHEMES)
"""How many the network finds."""

WARM_UP = 200
"""Steps in which the learning rate rises, of a training at least ``WARM_UP_SHARE`` times as long."""

WARM_UP_SHARE = 20
"""At most one in so many steps is for warming up."""

STEEPEST = 5.0
"""Length to which gradients are cut."""

VALIDATION_SHARE = 1.6
"""Of a window's side to that of the face on which the training is validated."""


class Pictures(Protocol):
    """Pictures with truth, by number."""

    @property
    def numbers(self) -> Sequence[int]:
        """Of the pictures."""

    @property
    def faces(self) -> Sequence[tuple[int, int]]:
        """Of every face the number of its picture, and its own there."""

    def marked(self, number: int) -> MarkedPicture:
        """A picture with its truth."""


class DetectorTraining:
    """Training of a DetectorNetwork that can stop after any epoch and go on from ``state()`` as if it had not.

    A step is on windows of random pictures, of which a part hold one face as it is cut out for its landmarks and the
    others anything; the former are asked for landmarks, the latter for faces, all for regions. What is kept
    is the moving average of the weights.

    Every draw comes from (seed, epoch, step, window), so nothing but weights, moments and counters has to be kept. With
    several processes each takes its share of every batch, and gradients are summed; normalisation is over the share.
    """

    def __init__(self, training: "Pictures", unseen: "Pictures", config: DetectorConfig, share: Share = ALL) -> None:
        """training, unseen: Pictures with faces; the latter to validate on.

        Raises InputError when one of them has no face.
        """
        for name, pictures in (("train", training), ("validate", unseen)):
            if not len(pictures.faces):
                raise InputError(f"expected pictures with faces to {name} on, found none")
        self.training = training
        self.unseen = unseen
        self.config = config
        self.share = share
        self.epoch = 0
        self.best = float("inf")
        generator = torch.Generator().manual_seed(config.seed)
        self.network = new_network(config, generator)
        self.average = new_network(config, generator)
        self.average.load_state_dict(self.network.state_dict())
        self.optimiser = torch.optim.AdamW(
            self.network.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay, fused=True
        )

    @property
    def ended(self) -> bool:
        """Whether all epochs are done."""
        return self.epoch >= self.config.epochs

    def copied_average(self) -> DetectorNetwork:
        """What is kept of the training, as a network of its own."""
        return copy.deepcopy(self.average)

    def state(self) -> dict:
        """Everything that the rest of the training depends on, for torch.save."""
        return {
            "network": self.network.state_dict(),
            "average": self.average.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "counters": [self.epoch, self.best],
        }

    def load_state(self, state: dict) -> None:
        """Go on from a state that ``state()`` gave. Raises InputError when it is of another training."""
        form = self.state() | {"optimiser": adam_form(self.optimiser, state.get("optimiser"))}
        require_like({name: state.get(name) for name in form}, form)
        self.network.load_state_dict(state["network"])
        self.average.load_state_dict(state["average"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.epoch, self.best = state["counters"]

    def start_from(self, network: DetectorNetwork) -> None:
        """Begin with the weights of another network. Raises InputError when it is of another size."""
        if network.size != self.network.size:
            raise InputError(f"expected a detector of {self.network.size}, found one of {network.size}")
        self.network.load_state_dict(network.state_dict())
        self.average.load_state_dict(network.state_dict())

    def epochs(self) -> Iterator[EpochRecord]:
        """Train, and yield what came of it after every epoch. Raises NumericsError when the loss is not finite.

        Errors are mean distances of landmarks, in training as a share of the window's side, in validation of the
        diagonal of the face.
        """
        config = self.config
        # Under deterministic algorithms PyTorch would fill all memory that it takes before it is written.
        torch.utils.deterministic.fill_uninitialized_memory = False  # type: ignore[attr-defined]
        while not self.ended:
            loss, error = self._train_epoch()
            self.epoch += 1
            validation = None
            best = False
            if self.epoch % config.validate_every == 0 or self.ended:
                validation = self._validate()
                best = validation < self.best
                self.best = min(validation, self.best)
            yield EpochRecord(self.epoch, loss, error, validation, best)

    def _train_epoch(self) -> tuple[float, float]:
        self.network.train()
        sums = torch.zeros(2)
        with ThreadPoolExecutor(1) as drawer:
            # The windows of the next step are drawn while this one is taken.
            drawn = drawer.submit(self._draw, 0)
            for step in range(self.config.steps):
                windows, crops = drawn.result()
                if step + 1 < self.config.steps:
                    drawn = drawer.submit(self._draw, step + 1)
                self._set_rate(self.epoch * self.config.steps + step)
                sums += self._step(step, windows, crops)
        if self.share.count > 1:
            self._share_buffers()
        loss, error = (sums / self.config.steps).tolist()
        return loss, error

    def _step(self, step: int, windows: list[MarkedPicture], crops: int) -> torch.Tensor:
        """Go one step down, on windows of ``_draw``. Returns loss and mean distance, of all processes together."""
        loss, distance = self._loss(windows, crops)
        figures = torch.stack([loss.detach(), distance]) / self.share.count
        self.optimiser.zero_grad()
        (loss / self.share.count).backward()
        if self.share.count > 1:
            for parameter in self.network.parameters():
                torch.distributed.all_reduce(parameter.grad)
            torch.distributed.all_reduce(figures)
        if not torch.isfinite(figures).all():
            raise NumericsError(f"the loss of epoch {self.epoch + 1} is not finite: a smaller learning_rate may help")
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), STEEPEST)
        self.optimiser.step()
        self._follow(self.epoch * self.config.steps + step)
        return figures

    def _draw(self, step: int) -> tuple[list[MarkedPicture], int]:
        """This process's windows of a step, and how many of them, the first, are of one face."""
        config = self.config
        crops = round(config.crops * config.batch)
        rows = range(self.share.process, config.batch, self.share.count)
        windows = []
        for row in rows:
            generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step, row])
            windows.append(self._window(row < crops, generator))
        return windows, sum(row < crops for row in rows)

    def _window(self, of_face: bool, generator: np.random.Generator) -> MarkedPicture:
        settings = WindowSettings()
        size = self.config.size
        if of_face:
            number, face = self.training.faces[int(generator.integers(len(self.training.faces)))]
            window = face_window(self.training.marked(number), face, size, settings, generator)
        else:
            number = self.training.numbers[int(generator.integers(len(self.training.numbers)))]
            window = any_window(self.training.marked(number), size, settings, generator)
        return disguise_window(window, generator)

    def _loss(self, windows: list[MarkedPicture], crops: int) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of windows, of which the first ``crops`` are of one face, and the mean distance of landmarks."""
        config = self.config
        pixels = torch.from_numpy(np.stack([window.pixels for window in windows])).permute(0, 3, 1, 2)
        with torch.autocast("cpu", torch.bfloat16, enabled=config.precision == "bfloat16"):
            features, levels = self.network.coarse(pixels)
            # Where a face is known to be in the middle, the network would learn the middle.
            grid = self.network.faces(features[crops:])
            fine = self.network.fine(features, levels)
            regions = self.network.parse(fine, levels)
            maps = self.network.read(fine[:crops])
        points = torch.from_numpy(np.stack([window.landmarks[0] for window in windows[:crops]])).float()
        visible = torch.from_numpy(np.stack([window.visible[0] for window in windows[:crops]]))
        loss, distance = landmark_loss(maps, points, visible, config.size, config)
        targets = FaceTargets.of(windows[crops:], config.size)
        loss = loss + config.face_weight * face_loss(grid, targets)
        truth = np.stack([window.regions for window in windows])
        return loss + config.parsing_weight * region_loss(regions, truth), distance

    @torch.no_grad()
    def _follow(self, step: int) -> None:
        """Let the average follow the weights: of the first steps quickly, because it starts where they did."""
        decay = min(self.config.decay, (1 + step) / (10 + step))
        for own, value in zip(self.average.state_dict().values(), self.network.state_dict().values(), strict=True):
            if own.is_floating_point():
                own.lerp_(value, 1 - decay)
            else:
                own.copy_(value)

    @torch.no_grad()
    def _validate(self) -> float:
        """Mean distance of the average's landmarks on unseen faces, of iBUG, as a share of the faces' diagonals."""
        self.average.eval()
        size = self.config.size
        chosen = self.unseen.faces[:: max(1, len(self.unseen.faces) // self.config.validation)]
        errors = []
        for number, face in chosen[: self.config.validation]:
            picture = self.unseen.marked(number)
            truth = picture.landmarks[face][:COUNT]
            matrix = FaceFrame.of(truth).matrix(size, VALIDATION_SHARE)
            pixels = cut_window(picture.pixels, matrix, (size, size)).astype(np.float32) / 255
            window = torch.from_numpy(pixels).permute(2, 0, 1)[None]
            mean = self.average.read(self.average.fine(*self.average.coarse(window))).mean[0, :COUNT].numpy()
            places = truth @ matrix[:, :2].T + matrix[:, 2]
            apart = np.linalg.norm((mean + 0.5) * FINE - 0.5 - places, axis=1)
            errors.append(apart.mean() / np.linalg.norm(np.ptp(places, axis=0)))
        return float(np.mean(errors))

    def _set_rate(self, step: int) -> None:
        total = self.config.epochs * self.config.steps
        factor = min(1.0, (step + 1) / min(WARM_UP, 1 + total // WARM_UP_SHARE))
        for group in self.optimiser.param_groups:
            group["lr"] = self.config.learning_rate * factor * 0.5 * (1 + cos(pi * step / total))

    def _share_buffers(self) -> None:
        """Let all processes have the same statistics of normalisation, their mean: that of the first is stored."""
        for network in (self.network, self.average):
            for buffer in network.buffers():
                if buffer.is_floating_point():
                    torch.distributed.all_reduce(buffer)
                    buffer /= self.share.count


def new_network(config: DetectorConfig, generator: torch.Generator) -> DetectorNetwork:
    """A network with random weights."""
    return DetectorNetwork(config.network(), LANDMARKS, len(Region), generator)
