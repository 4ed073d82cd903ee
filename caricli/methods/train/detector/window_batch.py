"""The windows of a step of a detector's training: drawn by any process, learnt from on any device."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import torch

from caricli.methods.train.detector.detector_losses import FaceTargets
from caricli.methods.train.detector.disguise_picture import disguise_window
from caricli.methods.train.detector.split_pictures import evenly_jawed
from caricli.methods.train.detector.windows import WindowSettings, any_window, face_window
from caricli.methods.train.processes import Share
from caricli.models.detector.config import DetectorConfig
from caricli.seeds import TrainingSeed
from caricli.structures.detection import MarkedPicture


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

    def landmarks(self) -> np.ndarray:
        """(F, L, 2) true landmarks of all faces, pixels of their pictures."""


@dataclass(frozen=True, eq=False)
class WindowBatch:
    """B windows of S pixels, of which the first C hold one face each, as arrays or, on a device, as tensors.

    pixels: (B, S, S, 3) uint8. regions: (B, S, S) uint8. points: (C, L, 2) pixels and visible: (C, L) bool, of the
    first. targets: FaceTargets of the others.
    """

    pixels: Any
    regions: Any
    points: Any
    visible: Any
    targets: FaceTargets

    @staticmethod
    def of(windows: Sequence[MarkedPicture], crops: int) -> "WindowBatch":
        """Windows as arrays. crops: how many of them, the first, hold one face."""
        faces = windows[:crops]
        return WindowBatch(
            np.stack([np.rint(255 * window.pixels).astype(np.uint8) for window in windows]),
            np.stack([window.regions for window in windows]),
            np.stack([window.landmarks[0] for window in faces]).astype(np.float32),
            np.stack([window.visible[0] for window in faces]),
            FaceTargets.of(windows[crops:], len(windows[0].pixels)),
        )

    def on(self, device: str) -> "WindowBatch":
        """The same as tensors on a device."""
        pixels, regions, points, visible, *targets = (
            torch.from_numpy(np.ascontiguousarray(array)).to(device)
            for array in (self.pixels, self.regions, self.points, self.visible, *self.targets.parts)
        )
        return WindowBatch(pixels, regions, points, visible, FaceTargets(*targets))


@dataclass(frozen=True)
class WindowSource:
    """Draws the windows of a step, the same in any process. share: which part of a step's are drawn."""

    pictures: Pictures
    config: DetectorConfig
    share: Share

    def draw(self, epoch: int, step: int) -> WindowBatch:
        """The windows of a step, as arrays."""
        config = self.config
        crops = config.faces
        rows = self.share.rows(config.batch)
        windows = []
        for row in rows:
            generator = np.random.default_rng([config.seed, TrainingSeed.STEP, epoch, step, row])
            windows.append(self._window(row < crops, generator))
        return WindowBatch.of(windows, sum(row < crops for row in rows))

    def _window(self, of_face: bool, generator: np.random.Generator) -> MarkedPicture:
        settings = WindowSettings()
        size = self.config.size
        if of_face:
            number, face = self.pictures.faces[int(generator.integers(len(self.pictures.faces)))]
            window = evenly_jawed(face_window(self.pictures.marked(number), face, size, settings, generator))
        else:
            number = self.pictures.numbers[int(generator.integers(len(self.pictures.numbers)))]
            window = any_window(self.pictures.marked(number), size, settings, generator)
        return disguise_window(window, generator)


def draw_step(source: WindowSource, job: tuple[int, int]) -> WindowBatch:
    """The windows of an epoch and a step, as a job of a ``worker_pool`` of sources."""
    return source.draw(*job)


class WindowsAhead:
    """Windows that other processes draw while a training learns: those of an epoch and of the next."""

    def __init__(self, run: Callable[..., Iterator[WindowBatch]], config: DetectorConfig) -> None:
        """run: of a ``worker_pool`` of WindowSources."""
        self._run = run
        self._config = config
        self._drawn: dict[int, Iterator[WindowBatch]] = {}

    def draw(self, epoch: int, step: int) -> WindowBatch:
        """The windows of a step, which must be asked for one after the other."""
        if step == 0:
            for later in (epoch, epoch + 1):
                if later not in self._drawn and later < self._config.epochs:
                    steps = range(self._config.steps // self._config.rounds)
                    self._drawn[later] = self._run(draw_step, [(later, number) for number in steps])
            self._drawn.pop(epoch - 1, None)
        return next(self._drawn[epoch])
