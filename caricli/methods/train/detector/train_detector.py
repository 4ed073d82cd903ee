"""A detector, trained on pictures whose truth is known."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import torch

from caricli.data.evenly import evenly
from caricli.errors import InputError
from caricli.methods.train.detector.detector_losses import face_loss, landmark_loss, region_loss
from caricli.methods.train.detector.split_pictures import evenly_jawed
from caricli.methods.train.detector.window_batch import Pictures, WindowBatch, WindowsAhead, WindowSource
from caricli.methods.train.detector.windows_again import joined_windows, picked_windows
from caricli.methods.train.kernel_muon import normalised_kernels
from caricli.methods.train.network_training import NetworkTraining, require_faces
from caricli.methods.train.processes import ALL, Share
from caricli.models.detector.config import FINE, HALF, DetectorConfig
from caricli.models.detector.networks import DetectorNetwork
from caricli.render.pixels.cut_window import cut_window
from caricli.seeds import TrainingSeed
from caricli.structures.detection import FaceFrame
from caricli.structures.landmarks import COUNT, SCHEMES
from caricli.structures.parsing import Region

LANDMARKS = max(SCHEMES)
"""How many the network finds."""

VALIDATION_SHARE = 1.6
"""Of a window's side to that of the face on which the training is validated."""


class DetectorTraining(NetworkTraining):
    """Training of a DetectorNetwork, as every NetworkTraining.

    A step is on windows of random pictures, of which a part hold one face as it is cut out for its landmarks and the
    others anything; the former are asked for landmarks, the latter for faces, all for regions. With several rounds the
    windows of an epoch are learnt from again, picked by chance, mirrored, bent and in other light. Errors are mean
    distances of landmarks, in training as a share of the window's side, in validation of the diagonal of the face.
    """

    def __init__(
        self, training: Pictures, unseen: Pictures, config: DetectorConfig, share: Share = ALL, device: str = "cpu"
    ) -> None:
        """training, unseen: Pictures with faces; the latter to validate on. device: "cpu" or "cuda".

        Raises InputError when one of them has no face.
        """
        require_faces(training, unseen)
        super().__init__(lambda generator: new_network(config, generator).to(device), config, share)
        self.training = training
        self.unseen = unseen
        self.device = device
        self.windows = WindowSource(training, config, share)
        self._ahead: WindowsAhead | None = None
        self._kept: list[WindowBatch] = []
        self._together: WindowBatch | None = None

    def _needed(self) -> dict[str, int]:
        config = self.config
        return {"windows of one face": config.faces, "other windows": config.batch - config.faces}

    def _kernels(self) -> Sequence[torch.Tensor]:
        return normalised_kernels(self.network)

    def start_from(self, network: DetectorNetwork) -> None:
        """Begin with the weights of another network. Raises InputError when it is of another size."""
        if network.size != self.network.size:
            raise InputError(f"expected a detector of {self.network.size}, found one of {network.size}")
        self.network.load_state_dict(network.state_dict())
        self.average.load_state_dict(network.state_dict())

    def draw_ahead(self, run: Callable[..., Iterator[WindowBatch]]) -> None:
        """Let other processes draw. run: of a ``worker_pool`` of ``windows``."""
        self._ahead = WindowsAhead(run, self.config)

    def _draw(self, step: int) -> WindowBatch:
        """This process's windows of a step: first all of the epoch are drawn, then they are learnt from again."""
        config = self.config
        if step < config.steps // config.rounds:
            drawn = self.windows.draw(self.epoch, step) if self._ahead is None else self._ahead.draw(self.epoch, step)
            batch = drawn.on(self.device)
            if config.rounds > 1:
                self._kept = [*(self._kept if step else []), batch]
            return batch
        if self._together is None or step == config.steps // config.rounds:
            self._together = joined_windows(self._kept)
        key = np.random.SeedSequence([config.seed, TrainingSeed.EXTRA, self.epoch, step, self.share.process])
        generator = torch.Generator(self.device).manual_seed(int(key.generate_state(1)[0]))
        return picked_windows(self._together, self._kept[0], generator)

    def _loss(self, batch: WindowBatch) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of windows, and the mean distance of landmarks."""
        config = self.config
        crops = len(batch.points)
        pixels = batch.pixels.permute(0, 3, 1, 2).float() / 255
        with torch.autocast(self.device, torch.bfloat16, enabled=config.precision == "bfloat16"):
            features, levels = self.network.coarse(pixels)
            # Where a face is known to be in the middle, the network would learn the middle.
            grid = self.network.faces(features[crops:])
            fine = self.network.fine(features, levels)
            regions = self.network.parse(fine, levels)
            maps = self.network.read(fine[:crops])
        loss, distance = landmark_loss(maps, batch.points, batch.visible, config.size, config)
        loss = loss + config.face_weight * face_loss(grid, batch.targets)
        return loss + config.parsing_weight * region_loss(regions, batch.regions[:, ::HALF, ::HALF]), distance

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
            window = torch.from_numpy(pixels).permute(2, 0, 1)[None].to(self.device)
            mean = self.average.read(self.average.fine(*self.average.coarse(window))).mean[0, :COUNT].cpu().numpy()
            places = truth @ matrix[:, :2].T + matrix[:, 2]
            apart = np.linalg.norm((mean + 0.5) * FINE - 0.5 - places, axis=1)
            errors.append(apart.mean() / np.linalg.norm(np.ptp(places, axis=0)))
        return float(np.mean(errors))


def new_network(config: DetectorConfig, generator: torch.Generator) -> DetectorNetwork:
    """A network with random weights."""
    return DetectorNetwork(config.network(), LANDMARKS, len(Region), generator)
