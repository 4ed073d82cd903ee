"""A coarse network, trained with the energy of the portrait paper and with what is true of rendered pictures."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import torch

from caricli.data.evenly import evenly
from caricli.errors import InputError
from caricli.methods.evaluate.reconstruct_portrait import shape_error
from caricli.methods.morphable.coefficients import CoefficientLayout
from caricli.methods.morphable.energy import Observed
from caricli.methods.morphable.renderer import MorphableRenderer
from caricli.methods.train.coarse.coarse_faces import (
    CoarseWindow,
    FaceSource,
    JoinedFaces,
    StudiedFace,
    TrueFace,
    WindowDrawer,
)
from caricli.methods.train.coarse.coarse_losses import ThinFace, Truth, truth_loss, window_energy
from caricli.methods.train.coarse.told_landmarks import (
    FACE_REGIONS,
    FaceMixer,
    ImaginedFace,
    Seer,
    cut_landmarks,
    hand_marked,
)
from caricli.methods.train.detector.windows import moved_window
from caricli.methods.train.network_training import NetworkTraining, require_faces
from caricli.methods.train.processes import ALL, Share
from caricli.models.coarse.config import CoarseConfig
from caricli.models.coarse.model import LANDMARKS, SHARE, shares, window_marks
from caricli.models.coarse.networks import CoarseNetwork, WindowFeatures
from caricli.models.detector.model import Detector
from caricli.models.morphable.model import MorphableModel
from caricli.seeds import TrainingSeed
from caricli.structures.detection import FaceFrame

LIGHT = (2.5, 0.0, 0.0, -0.8, *[0.0] * 5)
"""Harmonics of the light that the network begins with: from before the face."""


@dataclass(frozen=True, eq=False)
class Sources:
    """Faces to train on, with their truth; faces without it, or None; and faces to validate with."""

    true: JoinedFaces
    unmarked: FaceSource | None
    unseen: FaceSource


@dataclass(frozen=True, eq=False)
class Seen:
    """What losses take of B windows, of which the first U are without truth and the first N are painted, and I faces.

    pixels: (B, 3, S, S) where the encoder learns; else features: what it makes of them. told: (B + I, L, 5) what the
    network is told of landmarks. observed: images and confidence of the first N, landmarks of all. anchors: (B - U + I,
    L) vertices that the true landmarks stand on. truth: Truth of B - U + I.
    """

    pixels: torch.Tensor
    features: WindowFeatures | None
    told: torch.Tensor
    observed: Observed
    anchors: torch.Tensor
    truth: Truth


@dataclass(eq=False)
class Batch:
    """Windows of a step; and from when they were looked at, what is seen of them instead.

    number: its own in the epoch. times: how often it was gone through. marked: of every window landmarks (L, 2) as
    somebody marked them, or None. there: (L,) which of them are known. imagined: faces with the errors of a window's
    landmarks, by its number.
    """

    number: int
    windows: list[CoarseWindow] = field(default_factory=list)
    marked: list[np.ndarray | None] = field(default_factory=list)
    there: list[np.ndarray] = field(default_factory=list)
    imagined: list[tuple[int, ImaginedFace]] = field(default_factory=list)
    seen: Seen | None = None
    times: int = 0


class CoarseTraining(NetworkTraining):
    """Training of a CoarseNetwork, as every NetworkTraining.

    A step is on windows around faces of pictures without truth, where there are any, and on windows around rendered
    faces whose truth is known. The energy of equations 3 to 6 is taken of all; its photometric term of the former,
    under what the detector's parser says, and of a part of the latter, under the true label map. Both are left as they
    are, and the others are disguised. What is known of rendered faces counts besides: the mean distance of the
    vertices, the rotation, the colours of the vertices, and the coefficients that are the likeliest for them. The
    landmarks that the network is told are those that the detector sees in the very window, or such as somebody marks.
    Besides there are faces that are in no picture, mixed of those that are: of these the network is told landmarks
    alone, with the errors of a window's. With several rounds the windows of an epoch are gone through so often, and the
    encoder stays as it is.
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
        self.sources = sources
        super().__init__(partial(new_coarse_network, config, model), config, share)
        self.model = model
        self.seer = Seer(detector)
        self.renderer = MorphableRenderer(model)
        self.thin = ThinFace(self.renderer)
        self.drawer = WindowDrawer(model, config.size)
        self.mixer = FaceMixer(sources.true.shapes(), model.template, self.drawer.mean)
        self.kept: dict[int, Batch] = {}
        self.network.borrow(self.seer.network.state_dict())
        self.average.load_state_dict(self.network.state_dict())

    @property
    def _unmarked(self) -> int:
        """Windows of a batch without truth."""
        return 0 if self.sources.unmarked is None else self.config.unmarked

    def _needed(self) -> dict[str, int]:
        return {"windows with truth": self.config.batch - self._unmarked}

    @property
    def _shares(self) -> float:
        counts = (self.config.batch, self.config.imagined)
        return sum(counts) / sum(len(self.share.rows(count)) for count in counts)

    def _draw(self, step: int) -> "Batch":
        """This process's windows of a step: those without truth, those to be painted, and the others."""
        config = self.config
        number_of_batch = step % (config.steps // config.rounds)
        if number_of_batch < step:
            return self.kept[number_of_batch]
        unmarked = self._unmarked
        batch = Batch(number_of_batch)
        for row in self.share.rows(config.batch):
            generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step, row])
            source: FaceSource | None = self.sources.unmarked if row < unmarked else self.sources.true
            assert source is not None
            face = source.study(int(generator.integers(len(source.faces))))
            plain = row < unmarked + config.painted
            window = self.drawer.draw(face, plain, generator)
            points = window.picture.landmarks[0]
            batch.windows.append(window)
            batch.marked.append(None if row < unmarked else hand_marked(points, config.size, generator))
            batch.there.append(cut_landmarks(points, generator))
        true = [number for number, window in enumerate(batch.windows) if window.truth is not None]
        for row in self.share.rows(config.imagined):
            generator = np.random.default_rng([config.seed, TrainingSeed.STEP, self.epoch, step, config.batch + row])
            number = true[int(generator.integers(len(true)))]
            batch.imagined.append((number, self.mixer.draw(batch.windows[number], generator)))
        if config.rounds > 1:
            self.kept[number_of_batch] = batch
        return batch

    def _loss(self, drawn: "Batch") -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of windows, and the mean distance of the vertices of those with truth."""
        config = self.config
        if drawn.seen is None:
            drawn.seen = self._look(drawn)
            drawn.windows = []
            drawn.imagined = []
        seen = drawn.seen
        with torch.autocast("cpu", torch.bfloat16, enabled=config.precision == "bfloat16"):
            features = seen.features or self.network.encode(seen.pixels, seen.told[: len(seen.pixels)])
            coefficients = self.network.tell(self._dimmed(features, drawn), seen.told)
        drawn.times += 1
        unmarked = len(coefficients) - len(seen.truth.vertices)
        anchors = seen.anchors
        if unmarked:
            posed = self.renderer.pose(coefficients[:unmarked].detach())
            anchors = torch.cat([self.renderer.anchors(posed, LANDMARKS), anchors])
        energy = window_energy(self.thin, coefficients, seen.observed, anchors).mean()
        loss, distance = truth_loss(self.thin, coefficients[unmarked:], seen.truth, config)
        share = 1 - unmarked / len(coefficients)
        return config.energy_weight * energy + share * loss, distance

    def _dimmed(self, features: WindowFeatures, batch: "Batch") -> WindowFeatures:
        """Features without some of the landmarks and some of the places, the others larger for it."""
        config = self.config
        seed = [config.seed, TrainingSeed.DIM, self.epoch, batch.number, batch.times, self.share.process]
        generator = np.random.default_rng(seed)

        def kept(*shape: int) -> torch.Tensor:
            return torch.from_numpy((generator.random(shape) >= config.unseen) / np.float32(1 - config.unseen))

        whole = features.whole * kept(len(features.whole), 1, *features.whole.shape[2:])
        return WindowFeatures(whole, features.near * kept(*features.near.shape[:2], 1))

    @torch.no_grad()
    def _look(self, batch: "Batch") -> "Seen":
        """What losses take of a Batch."""
        windows = batch.windows
        images = torch.from_numpy(np.stack([window.picture.pixels for window in windows]))
        pixels = images.permute(0, 3, 1, 2)
        unmarked = sum(window.truth is None for window in windows)
        painted = sum(window.plain for window in windows)
        with torch.autocast("cpu", torch.bfloat16, enabled=self.config.precision == "bfloat16"):
            marks, parsed = self.seer.see(pixels, unmarked)
            told, truths, points = self._told(batch, marks)
            features = None
            if self.config.rounds > 1:
                features = self.average.eval().encode(pixels, told[: len(windows)])
                pixels = pixels[:0]
        regions = np.stack([window.picture.regions for window in windows])[unmarked:painted]
        skin = torch.cat([parsed, torch.from_numpy(np.isin(regions, FACE_REGIONS)).float()])
        observed = Observed(images[:painted], skin, torch.from_numpy(points).float())
        anchors = torch.from_numpy(np.stack([face.anchors for face in truths]))
        return Seen(pixels, features, told, observed, anchors, self.thin.truth(truths))

    def _told(self, batch: "Batch", marks: torch.Tensor) -> tuple[torch.Tensor, list[TrueFace], np.ndarray]:
        """What is told of landmarks (B + I, L, 5), where a detector says (B, L, 5); the truth, and landmarks."""
        size = self.config.size
        told = marks.clone()
        for row, marked in enumerate(batch.marked):
            if marked is not None:
                told[row] = torch.from_numpy(window_marks(marked, None, size))
            told[row, torch.from_numpy(~batch.there[row])] = torch.nan
        points = [window.picture.landmarks[0] for window in batch.windows]
        truths = [window.truth for window in batch.windows if window.truth is not None]
        imagined = []
        for number, face in batch.imagined:
            slip = torch.from_numpy(shares(face.points, size) - shares(points[number], size))
            imagined.append(told[number] + torch.cat([slip, torch.zeros(len(slip), told.shape[-1] - 2)], -1))
            points.append(face.points)
            truths.append(face.truth)
        return torch.stack([*told, *imagined]), truths, np.stack(points)

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
        coefficients = network(pixels, self.seer.see(pixels)[0])
        return coefficients[0, : self.renderer.layout.shape].double().numpy()

    def _unseen(self) -> Iterator[StudiedFace]:
        """The faces to validate with."""
        for number in evenly(range(len(self.sources.unseen.faces)), self.config.validation):
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
