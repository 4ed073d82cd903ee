"""A coarse network, trained with the energy of the portrait paper and with what is true of rendered pictures."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import torch

from caricli.errors import InputError
from caricli.methods.evaluate.reconstruct_portrait import shape_error
from caricli.methods.morphable.coefficients import CoefficientLayout
from caricli.methods.morphable.energy import Observed
from caricli.methods.morphable.renderer import MorphableRenderer
from caricli.methods.train.coarse_faces import CoarseWindow, FaceSource, StudiedFace, WindowDrawer
from caricli.methods.train.coarse_losses import ThinFace, Truth, truth_loss, window_energy
from caricli.methods.train.network_training import NetworkTraining, require_faces
from caricli.methods.train.train_autodecoder import ALL, Share
from caricli.methods.train.windows import moved_window
from caricli.models.coarse.config import CoarseConfig
from caricli.models.coarse.model import LANDMARKS, SHARE, shares
from caricli.models.coarse.networks import CoarseNetwork
from caricli.models.detector.model import Detector
from caricli.models.detector.networks import FINE, HALF
from caricli.models.morphable.model import MorphableModel
from caricli.seeds import TrainingSeed
from caricli.structures.detection import FaceFrame
from caricli.structures.parsing import Region

FACE_REGIONS = (Region.SKIN, Region.BROWS, Region.NOSE, Region.LIPS)
"""What of a picture the model's colours can explain: it has no eyeballs and no teeth, and wears nothing."""

LIGHT = (2.5, 0.0, 0.0, -0.8, *[0.0] * 5)
"""Harmonics of the light that the network begins with: from before the face."""


@dataclass(frozen=True, eq=False)
class Sources:
    """Faces to train on, with their truth; faces without it, or None; and faces to validate with."""

    true: FaceSource
    unmarked: FaceSource | None
    unseen: FaceSource


@dataclass(frozen=True, eq=False)
class Seen:
    """What losses take of B windows, of which the first U are without truth and the first N are painted.

    pixels: (B, 3, S, S), and features: (B, C, h, w) what a frozen encoder makes of them; one of both is empty. told:
    (B, L, 2) landmarks that the detector sees, shares of the side. observed: images and confidence of the first N,
    landmarks of all. anchors: (B - U, L) vertices that the true landmarks stand on. truth: Truth of B - U.
    """

    pixels: torch.Tensor
    features: torch.Tensor
    told: torch.Tensor
    observed: Observed
    anchors: torch.Tensor
    truth: Truth


@dataclass(eq=False)
class Batch:
    """Windows of a step; and from when they were looked at, what is seen of them instead."""

    windows: list[CoarseWindow]
    seen: Seen | None = None


class CoarseTraining(NetworkTraining):
    """Training of a CoarseNetwork, as every NetworkTraining.

    A step is on windows around faces of pictures without truth, where there are any, and on windows around rendered
    faces whose truth is known. The energy of equations 3 to 6 is taken of all; its photometric term of the former,
    under what the detector's parser says, and of a part of the latter, under the true label map. Both are left as they
    are, and the others are disguised. What is known of rendered faces counts besides: the mean distance of the
    vertices, the rotation, the colours of the vertices, and the coefficients that are the likeliest for them. The
    landmarks that the network is told are those that the detector sees in the very window. With several rounds the
    windows of an epoch are gone through so often, and the encoder stays as it is.
    Errors are distances of vertices as a share of the head's height, in validation of the face and after alignment.
    """

    def __init__(
        self, sources: Sources, model: MorphableModel, detector: Detector, config: CoarseConfig, share: Share = ALL
    ) -> None:
        """model: whose coefficients it learns. detector: with whose encoder it begins, if that is of the same size.

        Raises InputError when there are no faces to train or to validate with, or the detector takes other windows.
        """
        require_faces(sources.true, sources.unseen)
        if detector.size != config.size:
            raise InputError(f"expected a detector for windows of {config.size} pixels, found one for {detector.size}")
        super().__init__(partial(new_coarse_network, config, model), config, share)
        self.sources = sources
        self.model = model
        self.detector = detector.network.eval()
        self.renderer = MorphableRenderer(model)
        self.thin = ThinFace(self.renderer)
        self.drawer = WindowDrawer(model, config.size)
        self.kept: dict[int, Batch] = {}
        self.network.borrow(self.detector.state_dict())
        self.average.load_state_dict(self.network.state_dict())

    def _draw(self, step: int) -> "Batch":
        """This process's windows of a step: those without truth, those to be painted, and the others."""
        config = self.config
        number = step % (config.steps // config.rounds)
        if number < step:
            return self.kept[number]
        unmarked = 0 if self.sources.unmarked is None else config.unmarked
        windows = []
        for row in range(self.share.process, config.batch, self.share.count):
            generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step, row])
            source = self.sources.unmarked if row < unmarked else self.sources.true
            assert source is not None
            face = source.study(int(generator.integers(len(source.faces))))
            plain = row < unmarked + config.painted
            windows.append(self.drawer.draw(face, plain, generator))
        batch = Batch(windows)
        if config.rounds > 1:
            self.kept[number] = batch
        return batch

    def _loss(self, drawn: "Batch") -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of windows, and the mean distance of the vertices of those with truth."""
        config = self.config
        if drawn.seen is None:
            drawn.seen = self._look(drawn.windows)
            drawn.windows = []
        seen = drawn.seen
        with torch.autocast("cpu", torch.bfloat16, enabled=config.precision == "bfloat16"):
            features = self.network.encode(seen.pixels) if config.rounds == 1 else seen.features
            coefficients = self.network.tell(features, seen.told)
        unmarked = len(coefficients) - len(seen.truth.vertices)
        anchors = seen.anchors
        if unmarked:
            posed = self.renderer.pose(coefficients[:unmarked].detach())
            anchors = torch.cat([self.renderer.anchors(posed, LANDMARKS), anchors])
        energy = window_energy(self.thin, coefficients, seen.observed, anchors).mean()
        loss, distance = truth_loss(self.thin, coefficients[unmarked:], seen.truth, config)
        share = 1 - unmarked / len(coefficients)
        return config.energy_weight * energy + share * loss, distance

    @torch.no_grad()
    def _look(self, windows: list[CoarseWindow]) -> "Seen":
        """What losses take of windows."""
        pixels = torch.from_numpy(np.stack([window.picture.pixels for window in windows])).permute(0, 3, 1, 2)
        true = [window.truth for window in windows if window.truth is not None]
        unmarked = len(windows) - len(true)
        painted = sum(window.plain for window in windows)
        with torch.autocast("cpu", torch.bfloat16, enabled=self.config.precision == "bfloat16"):
            points, parsed = self._seen(pixels, unmarked)
            features = self.average.eval().encode(pixels) if self.config.rounds > 1 else pixels[:0]
        regions = np.stack([window.picture.regions for window in windows[unmarked:painted]])
        observed = Observed(
            pixels[:painted].permute(0, 2, 3, 1),
            torch.cat([parsed, torch.from_numpy(np.isin(regions, FACE_REGIONS)).float()]),
            torch.from_numpy(np.concatenate([window.picture.landmarks for window in windows])).float(),
        )
        anchors = torch.from_numpy(np.stack([face.anchors for face in true]))
        kept = pixels if self.config.rounds == 1 else pixels[:0]
        return Seen(kept, features, points, observed, anchors, self.thin.truth(true))

    @torch.no_grad()
    def _seen(self, pixels: torch.Tensor, parsed: int) -> tuple[torch.Tensor, torch.Tensor]:
        """What the detector sees in windows: landmarks as shares of the side, and in the first how surely skin is."""
        features, levels = self.detector.coarse(pixels)
        fine = self.detector.fine(features, levels)
        points = (self.detector.read(fine).mean + 0.5) * FINE / pixels.shape[-1]
        if not parsed:  # of no window PyTorch makes another shape
            return points, pixels.new_zeros(0, *pixels.shape[2:])
        first = [level[:parsed] for level in levels]
        chances = torch.softmax(self.detector.parse(fine[:parsed], first), -1)[..., list(FACE_REGIONS)].sum(-1)
        confidence = torch.nn.functional.pixel_shuffle(chances.permute(0, 3, 1, 2), FINE // HALF)
        return points, torch.nn.functional.interpolate(confidence, scale_factor=HALF)[:, 0]

    def _validate(self) -> float:
        """Mean distance of unseen faces to the true ones after alignment, as a share of their heads' height."""
        self.average.eval()
        errors = []
        for face in self._unseen():
            assert face.truth is not None
            vertices = self.model.decode(self.latent(self.average, face))
            errors.append(shape_error(vertices, face.truth.vertices.astype(float), self.model.template))
        return float(np.mean(errors)) / 100

    def doubts(self, network: CoarseNetwork) -> np.ndarray:
        """(D,) how far a network's coefficients are from the likeliest ones of unseen faces, 1 for light and pose.

        Root mean squares, of few people: each is the mean of its own and of that of its part, identity or expression.
        """
        layout = self.renderer.layout
        gaps = []
        for face in self._unseen():
            assert face.truth is not None
            gaps.append(self.latent(network, face) - self.model.encode(face.truth.vertices.astype(float)))
        squares = np.ones(layout.size)
        squares[: layout.shape] = np.mean(np.square(gaps), axis=0)
        parts = layout.parts(squares)
        for name in ("identity", "expression"):
            parts[name][:] = (parts[name] + parts[name].mean()) / 2
        return np.sqrt(squares)

    @torch.no_grad()
    def latent(self, network: CoarseNetwork, face: StudiedFace) -> np.ndarray:
        """Identity and expression (I + E,) that a network sees in a face, in the frame that it has in its picture."""
        window = moved_window(face.picture, face.frame.matrix(self.config.size, SHARE), self.config.size)
        pixels = torch.from_numpy(window.pixels.astype(np.float32) / 255).permute(2, 0, 1)[None]
        coefficients = network(pixels, self._seen(pixels, 0)[0])
        return coefficients[0, : self.renderer.layout.shape].double().numpy()

    def _unseen(self) -> Iterator[StudiedFace]:
        """The faces to validate with."""
        count = len(self.sources.unseen.faces)
        chosen = range(0, count, max(1, count // self.config.validation))
        for number in chosen[: self.config.validation]:
            yield self.sources.unseen.study(number)


def new_coarse_network(config: CoarseConfig, model: MorphableModel, generator: torch.Generator) -> CoarseNetwork:
    """A network with random weights that finds the model's mean from the front, in the middle of the window."""
    layout = CoefficientLayout.of(model)
    network = CoarseNetwork(config.network(), LANDMARKS, layout.size, generator)
    for encoder in (network.stem, network.down):
        encoder.requires_grad_(config.rounds == 1)
    front = model.mean[:, :2] * [1, -1]
    marks = front[model.template.annotation.landmarks]
    matrix = FaceFrame.of(marks).matrix(config.size, SHARE)
    middle = front.mean(0) @ matrix[:, :2].T + matrix[:, 2]
    scale = float(np.sqrt(np.linalg.det(matrix[:, :2])))
    start = {"light": LIGHT, "pose": (0, 0, 0, *middle, scale)}
    steps = {"light": (0.5,) * len(LIGHT), "pose": (*[0.3] * 3, *[0.05 * config.size] * 2, 0.1 * scale)}
    for buffer, values in ((network.start, start), (network.step, steps)):
        for name, part in values.items():
            layout.parts(buffer)[name][:] = torch.tensor(part)
    usual = shares(marks @ matrix[:, :2].T + matrix[:, 2], config.size)
    network.usual[: len(usual)] = torch.from_numpy(usual)
    return network
