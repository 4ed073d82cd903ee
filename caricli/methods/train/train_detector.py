"""A detector, trained on pictures whose truth is known."""

from collections.abc import Sequence
from functools import partial
from typing import Protocol, TypeVar

import numpy as np
import torch

from caricli.errors import InputError
from caricli.methods.train.detector_losses import FaceTargets, face_loss, landmark_loss, region_loss
from caricli.methods.train.disguise_picture import disguise_window
from caricli.methods.train.kernel_muon import normalised_kernels
from caricli.methods.train.network_training import NetworkTraining, require_faces
from caricli.methods.train.split_pictures import evenly_jawed
from caricli.methods.train.train_autodecoder import ALL, Share
from caricli.methods.train.windows import WindowSettings, any_window, face_window
from caricli.models.detector.config import FINE, DetectorConfig
from caricli.models.detector.networks import DetectorNetwork
from caricli.render.cut_window import cut_window
from caricli.seeds import TrainingSeed
from caricli.structures.detection import FaceFrame, MarkedPicture
from caricli.structures.landmarks import COUNT, SCHEMES
from caricli.structures.parsing import Region

T = TypeVar("T")

LANDMARKS = max(SCHEMES)
"""How many the network finds."""

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

    def landmarks(self) -> np.ndarray:
        """(F, L, 2) true landmarks of all faces, pixels of their pictures."""


class DetectorTraining(NetworkTraining):
    """Training of a DetectorNetwork, as every NetworkTraining.

    A step is on windows of random pictures, of which a part hold one face as it is cut out for its landmarks and the
    others anything; the former are asked for landmarks, the latter for faces, all for regions. Errors are mean
    distances of landmarks, in training as a share of the window's side, in validation of the diagonal of the face.
    """

    def __init__(self, training: "Pictures", unseen: "Pictures", config: DetectorConfig, share: Share = ALL) -> None:
        """training, unseen: Pictures with faces; the latter to validate on.

        Raises InputError when one of them has no face.
        """
        require_faces(training, unseen)
        super().__init__(partial(new_network, config), config, share)
        self.training = training
        self.unseen = unseen

    def _kernels(self) -> Sequence[torch.Tensor]:
        return normalised_kernels(self.network)

    def start_from(self, network: DetectorNetwork) -> None:
        """Begin with the weights of another network. Raises InputError when it is of another size."""
        if network.size != self.network.size:
            raise InputError(f"expected a detector of {self.network.size}, found one of {network.size}")
        self.network.load_state_dict(network.state_dict())
        self.average.load_state_dict(network.state_dict())

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
            window = evenly_jawed(face_window(self.training.marked(number), face, size, settings, generator))
        else:
            number = self.training.numbers[int(generator.integers(len(self.training.numbers)))]
            window = any_window(self.training.marked(number), size, settings, generator)
        return disguise_window(window, generator)

    def _loss(self, drawn: tuple[list[MarkedPicture], int]) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of windows, of which so many, the first, are of one face, and the mean distance of landmarks."""
        windows, crops = drawn
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
    def _validate(self) -> float:
        """Mean distance of the average's landmarks on unseen faces, of iBUG, as a share of the faces' diagonals."""
        self.average.eval()
        size = self.config.size
        errors = []
        for number, face in evenly(self.unseen.faces, self.config.validation):
            picture = evenly_jawed(self.unseen.marked(number))
            truth = picture.landmarks[face][:COUNT]
            matrix = FaceFrame.of(truth).matrix(size, VALIDATION_SHARE)
            pixels = cut_window(picture.pixels, matrix, (size, size)).astype(np.float32) / 255
            window = torch.from_numpy(pixels).permute(2, 0, 1)[None]
            mean = self.average.read(self.average.fine(*self.average.coarse(window))).mean[0, :COUNT].numpy()
            places = truth @ matrix[:, :2].T + matrix[:, 2]
            apart = np.linalg.norm((mean + 0.5) * FINE - 0.5 - places, axis=1)
            errors.append(apart.mean() / np.linalg.norm(np.ptp(places, axis=0)))
        return float(np.mean(errors))


def evenly(items: Sequence[T], count: int) -> Sequence[T]:
    """At most so many of some items, from all over them."""
    return items[:: max(1, len(items) // count)][:count]


def new_network(config: DetectorConfig, generator: torch.Generator) -> DetectorNetwork:
    """A network with random weights."""
    return DetectorNetwork(config.network(), LANDMARKS, len(Region), generator)
