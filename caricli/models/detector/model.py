"""The detector as it is used: weights, the size of its windows, and how far its doubts are to be trusted."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.special import expit

from caricli.errors import InputError, naming
from caricli.io.kept import kept_arrays
from caricli.models.checks import check_schema, network_size, window_side
from caricli.models.detector.calibration import Calibration, calibration_of
from caricli.models.detector.config import COARSE, FINE, HALF, REACH, STEP, DetectorSize
from caricli.models.detector.jaw_places import JawPlaces
from caricli.models.detector.landmark_heads import LandmarkHeads
from caricli.models.detector.usual_shapes import UsualShapes
from caricli.models.detector.weights import CHANCES, FACES, FEATURES, WINDOWS, DetectorWeights
from caricli.models.half_precision import in_half_precision
from caricli.models.model_id import NamedByWeights
from caricli.models.network_session import network_session
from caricli.structures.landmarks import SCHEMES
from caricli.structures.parsing import Region

SCHEMA = "caricli.detector/1"
LANDMARKS = max(SCHEMES)
"""Landmarks that are found."""

_SIDES = (64, 512)

JAW_WEIGHT = "jaw.weight"
JAW_BIAS = "jaw.bias"
JAW_USUAL = ("jaw.middle", "jaw.axes", "jaw.spreads")
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
    face in the middle. regions: (B, S / 2, S / 2, R) probabilities; for where they lie see Calibration.
    """

    points: np.ndarray
    covariance: np.ndarray
    visible: np.ndarray
    score: np.ndarray
    regions: np.ndarray


class Detector(NamedByWeights):
    """Finds faces in windows of pictures, and reads their landmarks and regions."""

    kind = "detector"

    def __init__(
        self,
        weights: DetectorWeights,
        size: int,
        calibration: Calibration | None = None,
        recipe: Any = None,
    ) -> None:
        """weights: DetectorWeights. size: of windows it was trained on, pixels. calibration: None for nothing known.

        recipe: JSON value, how it was trained, or None.
        Raises InputError for the weights of another network.
        """
        self.weights = weights
        self.size = size
        self.calibration = calibration or Calibration()
        self.recipe = recipe
        self._heads = LandmarkHeads.of(weights.arrays, LANDMARKS, weights.size.widths[0])
        self._session = network_session(_graph(weights))

    def tensors(self) -> dict[str, np.ndarray]:
        """Arrays by name: of the network, in half precision, and where the jaw's points are."""
        places = self.calibration.jaw
        jaw = {JAW_WEIGHT: places.weight, JAW_BIAS: places.bias}
        usual = places.usual
        if usual is not None:
            jaw |= dict(zip(JAW_USUAL, (usual.middle, usual.axes, usual.spreads), strict=True))
        exact = {name: array.astype(np.float32) for name, array in jaw.items()}
        return {**in_half_precision(self.weights.arrays), **exact}

    def search(self, window: np.ndarray) -> tuple[FaceCells, np.ndarray]:
        """What is at every cell of a window (H, W, 3) uint8 of any size, sides multiples of 32 pixels.

        Also returns what ``parse`` does.
        """
        faces, chances = self._run(window[None], FACES, CHANCES)
        return face_cells(faces[0]), by_pixels(chances)[0]

    def parse(self, window: np.ndarray) -> np.ndarray:
        """Probabilities of regions (H / 2, W / 2, R) of such a window; for where they lie see Calibration."""
        (chances,) = self._run(window[None], CHANCES)
        return by_pixels(chances)[0]

    def read(self, windows: np.ndarray) -> Reading:
        """Read windows (B, S, S, 3) uint8, S = ``size``, each with one upright face in its middle."""
        faces, features, chances = self._run(windows, FACES, FEATURES, CHANCES)
        places = self._heads.read(features)
        middle = slice(self.size // COARSE // 2 - 1, self.size // COARSE // 2 + 1)
        return Reading(
            (places.mean + 0.5) * FINE - 0.5,
            places.covariance * (FINE * self.calibration.trust) ** 2,
            expit(places.visible),
            expit(faces[:, 0, middle, middle].max((1, 2)).astype(np.float64)),
            by_pixels(chances),
        )

    def _run(self, windows: np.ndarray, *results: str) -> list[np.ndarray]:
        """Results of `detector_graph` for windows (B, H, W, 3) uint8."""
        count, height, width, channels = windows.shape
        cells = windows.reshape(count, height // HALF, HALF, width // HALF, HALF, channels).transpose(0, 5, 2, 4, 1, 3)
        values = cells.reshape(count, channels * HALF**2, height // HALF, width // HALF) * np.float32(2 / 255) - 1
        return self._session.run(results, {WINDOWS: values.astype(np.float32)})


def _graph(weights: DetectorWeights) -> bytes:
    """`detector_graph`, which is kept: importing `onnx` takes longer than all else here."""

    def make() -> dict[str, np.ndarray]:
        from caricli.models.detector.graph import detector_graph

        return {"graph": np.frombuffer(detector_graph(weights, len(Region)), np.uint8)}

    given: list[np.ndarray | str | float] = [str(weights.size), len(Region)]
    for name, array in weights.arrays.items():
        given += [name, array]
    return kept_arrays("detector", given, make)["graph"].tobytes()


def face_cells(grid: np.ndarray) -> FaceCells:
    """What a grid (6, h, w) says, see ``networks.FaceGrid``, in the window's pixels."""
    score, right, down, size, cosine, sine = grid.reshape(6, -1)
    cell = np.indices(grid.shape[1:]).reshape(2, -1).T
    centre = (cell[:, ::-1] + np.stack([right, down], 1) + 0.5) * COARSE - 0.5
    return FaceCells(expit(score), centre, REACH * np.exp2(np.clip(size, -6, 6)), np.arctan2(sine, cosine), cell)


def detector_to_checkpoint(detector: Detector) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A detector as (tensors, metadata), from which ``detector_from_checkpoint`` rebuilds it."""
    about = {"schema": SCHEMA, "network": asdict(detector.weights.size), "size": detector.size}
    about |= {"trust": detector.calibration.trust, "shift": list(detector.calibration.shift)}
    about["regions"] = [region.name.lower() for region in Region]
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
        size = window_side(metadata.get("size"), _SIDES, STEP)
        calibration = calibration_of(metadata, _jaw(tensors))
        own = {name: array for name, array in tensors.items() if name not in (JAW_WEIGHT, JAW_BIAS, *JAW_USUAL)}
        network = metadata.get("network")
        if isinstance(network, dict):
            network = {"finer": 0} | network  # which detectors of before had not
        weights = DetectorWeights(own, network_size(network, DetectorSize))
        return Detector(weights, size, calibration, metadata.get("recipe"))


def _jaw(tensors: Mapping[str, np.ndarray]) -> JawPlaces | None:
    """Where the jaw's points are, or None where a detector of before does not tell."""
    told = _together(tensors, (JAW_WEIGHT, JAW_BIAS))
    usual = _together(tensors, JAW_USUAL)
    if told is None:
        return None
    weight, bias = told
    return JawPlaces(weight, bias, None if usual is None else UsualShapes(*usual))


def _together(tensors: Mapping[str, np.ndarray], names: Sequence[str]) -> list[np.ndarray] | None:
    """Arrays of names, float64, or None where there is none of them. Raises InputError where there are but some."""
    there = [name in tensors for name in names]
    if not any(there):
        return None
    if not all(there):
        raise InputError(f"expected {', '.join(names)}, found {sum(there)} of them")
    return [tensors[name].astype(np.float64) for name in names]


def by_pixels(cells: np.ndarray) -> np.ndarray:
    """Values (B, h, w, 4, R) of the pixels in every cell, by rows, as (B, 2 h, 2 w, R)."""
    count, height, width, _, regions = cells.shape
    pixels = cells.reshape(count, height, width, HALF, HALF, regions).swapaxes(2, 3)
    return pixels.reshape(count, HALF * height, HALF * width, regions)
