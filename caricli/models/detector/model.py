"""The detector as it is used: weights, the size of its windows, and how far its doubts are to be trusted."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
import torch

from caricli.errors import InputError, naming, shown
from caricli.models.detector.config import DetectorSize
from caricli.models.detector.jaw_places import JawPlaces
from caricli.models.detector.networks import COARSE, FINE, HALF, REACH, DetectorNetwork, FaceGrid
from caricli.models.network_model import NetworkModel
from caricli.models.network_weights import check_schema, load_weights, whole_number
from caricli.structures.landmarks import SCHEMES
from caricli.structures.parsing import Region

SCHEMA = "caricli.detector/1"
LANDMARKS = max(SCHEMES)
"""Landmarks that are found."""

TRUST = (0.01, 100.0)
"""Of what doubts are multiplied by, the least and the most."""

_SIDES = (64, 512)

JAW_WEIGHT = "jaw.weight"
JAW_BIAS = "jaw.bias"
"""Names of the arrays of JawPlaces in a file."""


@dataclass(frozen=True, eq=False)
class FaceCells:
    """What a window shows of faces: at each of n cells.

    score: (n,) 0 to 1. centre: (n, 2) pixels. side: (n,) pixels. roll: (n,) radians, clockwise. cell: (n, 2) row and
    column.
    """

    score: np.ndarray
    centre: np.ndarray
    side: np.ndarray
    roll: np.ndarray
    cell: np.ndarray


@dataclass(frozen=True, eq=False)
class Reading:
    """What windows show of one face each, in their pixels.

    points: (B, 81, 2). covariance: (B, 81, 2, 2) square pixels. visible: (B, 81) 0 to 1. score: (B,) 0 to 1, of the
    face in the middle. regions: (B, S / 2, S / 2, R) probabilities; the pixel j is at 2 j of the window.
    """

    points: np.ndarray
    covariance: np.ndarray
    visible: np.ndarray
    score: np.ndarray
    regions: np.ndarray


class Detector(NetworkModel[DetectorNetwork]):
    """Finds faces in windows of pictures, and reads their landmarks and regions."""

    kind = "detector"

    def __init__(
        self,
        network: DetectorNetwork,
        size: int,
        trust: float = 1.0,
        recipe: Any = None,
        jaw: JawPlaces | None = None,
    ) -> None:
        """network: weights. size: of the windows it was trained on, pixels. trust: what its doubts are multiplied by.

        recipe: JSON value, how it was trained, or None. jaw: JawPlaces, or None for equal distances.
        """
        super().__init__(network, recipe)
        self.size = size
        self.trust = trust
        self.jaw = JawPlaces.even() if jaw is None else jaw

    def tensors(self) -> dict[str, np.ndarray]:
        """Arrays by name: of the network, and where the jaw's points are."""
        return super().tensors() | {JAW_WEIGHT: _single(self.jaw.weight), JAW_BIAS: _single(self.jaw.bias)}

    @torch.inference_mode()
    def search(self, window: np.ndarray) -> tuple[FaceCells, np.ndarray]:
        """What is at every cell of a window (H, W, 3) uint8 of any size, sides multiples of 32 pixels.

        Also returns what ``parse`` does.
        """
        features, levels = self.network.coarse(_tensor(window[None]))
        cells = face_cells(self.network.faces(features))
        return cells, _probabilities(self.network.parse(self.network.fine(features, levels), levels))[0]

    @torch.inference_mode()
    def parse(self, window: np.ndarray) -> np.ndarray:
        """Probabilities of regions (H / 2, W / 2, R) of such a window; the pixel j is at 2 j of the window."""
        features, levels = self.network.coarse(_tensor(window[None]))
        return _probabilities(self.network.parse(self.network.fine(features, levels), levels))[0]

    @torch.inference_mode()
    def read(self, windows: np.ndarray) -> Reading:
        """Read windows (B, S, S, 3) uint8, S = ``size``, each with one upright face in its middle."""
        features, levels = self.network.coarse(_tensor(windows))
        grid = self.network.faces(features)
        fine = self.network.fine(features, levels)
        maps = self.network.read(fine)
        middle = slice(self.size // COARSE // 2 - 1, self.size // COARSE // 2 + 1)
        score = torch.sigmoid(grid.score[:, middle, middle]).amax((1, 2))
        return Reading(
            (maps.mean.double().numpy() + 0.5) * FINE - 0.5,
            maps.covariance.double().numpy() * (FINE * self.trust) ** 2,
            torch.sigmoid(maps.visible).double().numpy(),
            score.double().numpy(),
            _probabilities(self.network.parse(fine, levels)),
        )


def face_cells(grid: FaceGrid) -> FaceCells:
    """What the grid of the first window says, in the window's pixels."""
    score = torch.sigmoid(grid.score[0]).numpy()
    cell = np.indices(score.shape).reshape(2, -1).T
    shift = grid.shift[0].numpy().transpose(1, 2, 0).reshape(-1, 2)
    cosine, sine = grid.turn[0].numpy().reshape(2, -1)
    centre = (cell[:, ::-1] + shift + 0.5) * COARSE - 0.5
    side = REACH * np.exp2(np.clip(grid.size[0].numpy().ravel(), -6, 6))
    return FaceCells(score.ravel(), centre, side, np.arctan2(sine, cosine), cell)


def detector_to_checkpoint(detector: Detector) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A detector as (tensors, metadata), from which ``detector_from_checkpoint`` rebuilds it."""
    about = {"schema": SCHEMA, "network": asdict(detector.network.size), "size": detector.size}
    about |= {"trust": detector.trust, "regions": [region.name.lower() for region in Region]}
    about["recipe"] = detector.recipe
    return detector.tensors(), about


def detector_from_checkpoint(tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object) -> Detector:
    """Rebuild a Detector.

    tensors, metadata: of ``detector_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit.
    """
    with naming(where):
        check_schema(metadata, SCHEMA, "detector")
        if metadata.get("regions") != [region.name.lower() for region in Region]:
            raise InputError("expected a detector of the regions that caricli knows, found another")
        size = whole_number(metadata.get("size"), _SIDES, "size")
        trust = metadata.get("trust")
        if not isinstance(trust, float) or not TRUST[0] <= trust <= TRUST[1]:
            raise InputError(f"expected a trust from {TRUST[0]:g} to {TRUST[1]:g}, found {shown(trust, 60)!r}")
        network = _network(metadata.get("network"))
        load_weights(network, {name: array for name, array in tensors.items() if name not in (JAW_WEIGHT, JAW_BIAS)})
        return Detector(network, size, trust, metadata.get("recipe"), _jaw(tensors))


def _jaw(tensors: Mapping[str, np.ndarray]) -> JawPlaces | None:
    """Where the jaw's points are, or None where a detector of before does not tell."""
    if JAW_WEIGHT not in tensors and JAW_BIAS not in tensors:
        return None
    if JAW_WEIGHT not in tensors or JAW_BIAS not in tensors:
        raise InputError(f"expected {JAW_WEIGHT} and {JAW_BIAS}, found one of them")
    return JawPlaces(tensors[JAW_WEIGHT].astype(np.float64), tensors[JAW_BIAS].astype(np.float64))


def _single(array: np.ndarray) -> np.ndarray:
    return array.astype(np.float32)


def _network(about: Any) -> DetectorNetwork:
    names = [field.name for field in fields(DetectorSize)]
    if not isinstance(about, dict) or sorted(about) != sorted(names):
        raise InputError(f"expected a network of {', '.join(names)}, found {shown(about, 60)!r}")
    try:
        size = DetectorSize(**{name: whole_number(about[name], (1, 512), name) for name in names})
    except ValueError as error:
        raise InputError(str(error)) from error
    return DetectorNetwork(size, LANDMARKS, len(Region), None)


def _tensor(windows: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(windows.astype(np.float32) / 255).permute(0, 3, 1, 2)


def _probabilities(logits: torch.Tensor) -> np.ndarray:
    """Logits (B, h, w, 4, R) of ``DetectorNetwork.parse`` to probabilities (B, 2 h, 2 w, R)."""
    step = FINE // HALF
    chances = torch.softmax(logits, -1)
    count, height, width, _, regions = chances.shape
    cells = chances.view(count, height, width, step, step, regions).permute(0, 1, 3, 2, 4, 5)
    return cells.reshape(count, height * step, width * step, regions).numpy()
