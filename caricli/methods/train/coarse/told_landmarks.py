"""What a coarse network is told of landmarks in its training: as a detector sees them, or as people mark them."""

from dataclasses import dataclass

import numpy as np
import torch

from caricli.geometry.lines.space_jaw import space_jaw
from caricli.methods.detect.settings import DetectSettings
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.train.coarse.coarse_faces import CoarseWindow, TrueFace, in_place
from caricli.models.coarse.model import LANDMARKS
from caricli.models.detector.config import FINE, HALF
from caricli.models.detector.model import Detector
from caricli.models.detector.networks import network_of
from caricli.structures.landmarks import COUNT, MIRRORED
from caricli.structures.parsing import Region
from caricli.template.template import Template

FACE_REGIONS = (Region.SKIN, Region.BROWS, Region.NOSE, Region.LIPS)
"""What of a picture the model's colours can explain: it has no eyeballs and no teeth, and wears nothing."""


@dataclass(frozen=True)
class ToldSettings:
    """What is told of landmarks.

    marked: share of the windows whose landmarks are true ones, nearly, without doubts; fewer: of these, how many have
    those of iBUG alone. slip: their errors, of the window's side. cut: share of the windows of whose landmarks those
    beyond a straight line are not known; most: share of the landmarks, at most. mixed: how far a face that nobody drew
    goes from one to another, at most.
    """

    marked: float = 0.15
    fewer: float = 0.5
    slip: float = 0.003
    cut: float = 0.1
    most: float = 0.3
    mixed: float = 0.6


@dataclass(frozen=True, eq=False)
class ImaginedFace:
    """A face that is in no picture, before the camera of a window. truth: TrueFace. points: (L, 2) window's pixels."""

    truth: TrueFace
    points: np.ndarray


class FaceMixer:
    """Draws faces that nobody drew: the difference of two is added to a third."""

    def __init__(self, shapes: np.ndarray, template: Template, mean: np.ndarray) -> None:
        """shapes: (N, V, 3) float32, see TrueFace. mean: (F, 3) see ``in_place``."""
        self.shapes = shapes
        self.template = template
        self.mean = mean
        self.settings = ToldSettings()

    def draw(self, window: CoarseWindow, generator: np.random.Generator) -> ImaginedFace:
        """One that looks at the camera as the face of a window does, and is as large."""
        assert window.truth is not None
        first, second, third = self.shapes[generator.integers(len(self.shapes), size=3)]
        vertices = first + generator.uniform(0, self.settings.mixed) * (second - third).astype(float)
        rotation = window.truth.rotation
        anchors = landmark_vertices(vertices, rotation, self.template, LANDMARKS)
        flat = (vertices[anchors] @ rotation.T)[:, :2]
        flat = flat - flat[:COUNT].mean(0)
        marks = window.picture.landmarks[0, :COUNT]
        middle = marks.mean(0)
        scale = (flat[:COUNT] * (marks - middle)).sum() / (flat[:COUNT] ** 2).sum()
        placed, turn = in_place(vertices, self.template, self.mean)
        return ImaginedFace(TrueFace(placed, window.truth.albedo, anchors, rotation @ turn.T), scale * flat + middle)


def hand_marked(points: np.ndarray, size: int, generator: np.random.Generator) -> np.ndarray | None:
    """Landmarks (L, 2) of a window as somebody marks them, or None in windows whose landmarks a detector sees."""
    settings = ToldSettings()
    if generator.random() >= settings.marked:
        return None
    marked = points + settings.slip * size * generator.normal(size=points.shape)
    if generator.random() < settings.fewer:
        marked[COUNT:] = np.nan
    return marked


def cut_landmarks(points: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """(L,) which landmarks (L, 2) are not beyond a line that a picture may end at."""
    settings = ToldSettings()
    if generator.random() >= settings.cut:
        return np.ones(len(points), bool)
    along = points @ generator.normal(size=2)
    return along <= np.nanquantile(along, 1 - generator.uniform(0, settings.most))


class Seer:
    """What a detector sees in windows: landmarks, and where bare skin is."""

    def __init__(self, detector: Detector) -> None:
        """detector: as it is."""
        self.network = network_of(detector)
        self.size = detector.size
        self.trust = detector.calibration.trust

    @torch.no_grad()
    def see(self, pixels: torch.Tensor, parsed: int = 0) -> tuple[torch.Tensor, torch.Tensor]:
        """What a CoarseNetwork is told of the landmarks (B, L, 5) in windows (B, 3, S, S), as pictures are read.

        That is, means of a window and its mirror image, the jaw spaced, without those that are too vague.
        parsed: in how many of the first windows bare skin is looked for. Returns them and (parsed, S, S) how surely
        pixels show it.
        """
        features, levels = self.network.coarse(torch.cat([pixels, pixels.flip(-1)]))
        fine = self.network.fine(features, levels)
        maps = self.network.read(fine)
        mirror = maps.mean.new_tensor([-1.0, 1.0])
        own, other = ((maps.mean + 0.5) * FINE / self.size).chunk(2)
        other = other[:, list(MIRRORED)] * mirror + mirror.new_tensor([1.0, 0.0])
        spread, spread_other = (maps.covariance * (FINE * self.trust / self.size) ** 2).chunk(2)
        apart = (own - other) / 2
        spread = (spread + spread_other[:, list(MIRRORED)] * mirror[:, None] * mirror) / 2
        spread = spread + apart[..., :, None] * apart[..., None, :]
        points = torch.from_numpy(np.stack([space_jaw(each) for each in ((own + other) / 2).double().numpy()])).float()
        doubts = torch.stack([spread[..., 0, 0], spread[..., 1, 1], spread[..., 0, 1]], -1)
        diagonal = torch.linalg.vector_norm(points.amax(1) - points.amin(1), dim=-1)[:, None]
        vague = torch.linalg.eigvalsh(spread.float())[..., 1].clamp(min=0).sqrt() > DetectSettings().vague * diagonal
        marks = torch.cat([points, doubts.float()], -1).masked_fill(vague[..., None], torch.nan)
        if not parsed:  # of no window PyTorch makes another shape
            return marks, pixels.new_zeros(0, *pixels.shape[2:])
        first = [level[:parsed] for level in levels]
        chances = torch.softmax(self.network.parse(fine[:parsed], first), -1)[..., list(FACE_REGIONS)].sum(-1)
        confidence = torch.nn.functional.pixel_shuffle(chances.permute(0, 3, 1, 2), FINE // HALF)
        return marks, torch.nn.functional.interpolate(confidence, scale_factor=HALF)[:, 0]
