"""How well a detector finds faces, landmarks and regions in pictures whose truth is known."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from caricli.methods.detect.detect_faces import detect_faces
from caricli.methods.detect.find_faces import frames_overlap
from caricli.models.detector.model import Detector
from caricli.structures.detection import DetectedFace, Detection, FaceFrame, MarkedPicture
from caricli.structures.landmarks import COUNT, PARTS
from caricli.structures.parsing import Region

SAME = 0.4
"""Overlap of frames from which on a face is the one that was found."""

FAILED = 8.0
"""NME in percent, above which a face counts as missed by its landmarks."""

SMALLEST = 1 / 12
"""Side of a face as a share of the picture's longer side, from which on it should be found."""

HALF = 0.5
"""Share of a face's landmarks of iBUG within the picture, from which on it should be found."""

SEEN = 1 / 3
"""Share of them that nothing hides, likewise."""

YAWS = (20, 45, 90)
"""Degrees: upper ends of the classes of poses."""

UNKNOWN = 255
"""Region of pixels of which nothing is known."""

WITHIN = 0.6827
"""Share of errors within one standard deviation, of normal ones along one axis."""


@dataclass(frozen=True, eq=False)
class JudgedPicture:
    """A picture, what is true of it, and how it is counted.

    marked: MarkedPicture. name: what reports call it. medium: how it is made. yaws: (M,) degrees, or None where nothing
    is known of them.
    """

    marked: MarkedPicture
    name: str
    medium: str
    yaws: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class FaceResult:
    """What was found of a true face.

    picture, medium: of its picture. yaw: degrees, or None. nme: percent by part of which something is known and "all",
    or None where it was not found. ratios: (n, 2) errors of its visible landmarks over their spreads, along the axis of
    the larger one and of the smaller. unknown: landmarks that were said to be not known. shape: (68, 2) true landmarks
    in their frame.
    """

    picture: str
    medium: str
    yaw: float | None
    nme: dict[str, float] | None
    ratios: np.ndarray
    unknown: int
    shape: np.ndarray


@dataclass
class DetectorTally:
    """Results of faces, and counts over pictures.

    false: faces that were found where there is none. confusion: (R, R) pixels by true and by found region.
    """

    faces: list[FaceResult] = field(default_factory=list)
    false: int = 0
    pictures: int = 0
    confusion: np.ndarray = field(default_factory=lambda: np.zeros((len(Region), len(Region)), np.int64))

    def add(self, judged: JudgedPicture, detection: Detection) -> None:
        """Count a picture."""
        self.pictures += 1
        own, others = _match(judged.marked, detection)
        self.false += others
        for number, face in own.items():
            self.faces.append(_face_result(judged, number, face))
        told = judged.marked.regions < len(Region)
        pairs = judged.marked.regions[told].astype(np.int64) * len(Region) + detection.regions[told]
        self.confusion += np.bincount(pairs, minlength=len(Region) ** 2).reshape(self.confusion.shape)

    @property
    def trust(self) -> float:
        """What spreads must be multiplied by for WITHIN of the errors to be within one; 1 where there are none."""
        ratios = _all_ratios(self.faces)
        return float(np.quantile(ratios, WITHIN)) if len(ratios) else 1.0

    def trusting(self, trust: float) -> "DetectorTally":
        """The same, as if all spreads had been multiplied by ``trust``."""
        faces = [replace(face, ratios=face.ratios / trust) for face in self.faces]
        return replace(self, faces=faces)

    @property
    def figures(self) -> dict:
        """JSON object: counts, NME by part, medium and pose, beside the mean shape, IoU of regions, calibration."""
        caught = [face for face in self.faces if face.nme is not None]
        count = len(self.faces)
        failed = count - sum(face.nme["all"] <= FAILED for face in caught if face.nme is not None)
        detected = len(caught) + self.false
        return {
            "pictures": self.pictures,
            "faces": count,
            "recall": len(caught) / max(count, 1),
            "precision": len(caught) / max(detected, 1),
            "false": self.false,
            "failed": failed / max(count, 1),
            "nme": _mean_nme(caught),
            "median": float(np.median([face.nme["all"] for face in caught if face.nme])) if caught else None,
            "mean_shape": _mean_shape_nme(self.faces),
            "media": _by_class(self.faces, lambda face: face.medium),
            "yaws": _by_class(self.faces, lambda face: _yaw_class(face.yaw)),
            "unknown": float(np.mean([face.unknown for face in caught])) if caught else None,
            "within": _calibration(caught),
            "iou": self.intersections,
        }

    @property
    def intersections(self) -> dict[str, float]:
        """Intersection over union by region that is there, and their mean."""
        common = np.diag(self.confusion)
        union = self.confusion.sum(0) + self.confusion.sum(1) - common
        there = self.confusion.sum(1) > 0
        values = {region.name.lower(): float(common[region] / union[region]) for region in Region if there[region]}
        return values | {"mean": float(np.mean(list(values.values())))} if values else {}


def evaluate_detector(
    detector: Detector, pictures: Iterable[JudgedPicture]
) -> Iterator[tuple[JudgedPicture, Detection]]:
    """Detect faces in pictures, and yield each with what was found, to be put into a DetectorTally."""
    for judged in pictures:
        yield judged, detect_faces(judged.marked.pixels, detector)


def _match(marked: MarkedPicture, detection: Detection) -> tuple[dict[int, DetectedFace | None], int]:
    """Of every true face that should be found the one that is; and how many were found where there is none.

    Faces that are too small, too far beyond the edge or too much hidden are neither missed nor false.
    """
    frames = [FaceFrame.of(points) for points in marked.landmarks]
    pairs = [(frames_overlap(a, b.frame), i, j) for i, a in enumerate(frames) for j, b in enumerate(detection.faces)]
    partner: dict[int, DetectedFace] = {}
    taken: set[int] = set()
    for overlap, i, j in sorted(pairs, key=lambda pair: -pair[0]):
        if overlap >= SAME and i not in partner and j not in taken:
            partner[i] = detection.faces[j]
            taken.add(j)
    asked = {i: partner.get(i) for i in range(len(frames)) if _should_be_found(marked, i, frames[i])}
    return asked, len(detection.faces) - len(taken)


def _should_be_found(marked: MarkedPicture, number: int, frame: FaceFrame) -> bool:
    height, width = marked.regions.shape
    points = marked.landmarks[number][:COUNT]
    inside = ((points >= -0.5) & (points <= np.array([width, height]) - 0.5)).all(1)
    visible = marked.visible[number][:COUNT]
    large = frame.side >= SMALLEST * max(height, width)
    return bool(large and inside.mean() >= HALF and (inside & visible).mean() >= SEEN)


def _face_result(judged: JudgedPicture, number: int, face: DetectedFace | None) -> FaceResult:
    truth = judged.marked.landmarks[number]
    yaw = None if judged.yaws is None else float(judged.yaws[number])
    frame = FaceFrame.of(truth)
    matrix = frame.matrix(1, 1.0)
    shape = truth[:COUNT] @ matrix[:, :2].T + matrix[:, 2]
    if face is None:
        return FaceResult(judged.name, judged.medium, yaw, None, np.zeros((0, 2)), 0, shape)
    count = len(truth)
    marks = face.landmarks
    errors = np.linalg.norm(marks.points[:count] - truth, axis=1)
    diagonal = np.linalg.norm(np.ptp(truth[:COUNT], axis=0))
    parts = {name: list(part) for name, part in PARTS.items() if max(part) < count} | {"all": list(range(COUNT))}
    shares = {name: 100 * errors[part] / diagonal for name, part in parts.items()}
    nme = {name: float(own[np.isfinite(own)].mean()) for name, own in shares.items() if np.isfinite(own).any()}
    clear = marks.known[:count] & judged.marked.visible[number] & np.isfinite(truth).all(1)
    ratios = _ratios(marks.points[:count][clear] - truth[clear], marks.spreads[:count][clear])  # type: ignore[index]
    unknown = int((~marks.known).sum())
    return FaceResult(judged.name, judged.medium, yaw, nme, ratios, unknown, shape)


def _ratios(errors: np.ndarray, spreads: np.ndarray) -> np.ndarray:
    """(n, 2) sizes of errors (n, 2) along the axes of their spreads (n, 2, 2), in deviations, largest first."""
    values, vectors = np.linalg.eigh(spreads)
    along = np.einsum("nij,ni->nj", vectors, errors)
    return (np.abs(along) / np.sqrt(values))[:, ::-1]


def _mean_nme(caught: list[FaceResult]) -> dict[str, float]:
    rows = [face.nme for face in caught if face.nme is not None]
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: float(np.mean([row[name] for row in rows if name in row])) for name in names}


def _by_class(faces: list[FaceResult], name_of: Callable[[FaceResult], str | None]) -> dict[str, dict]:
    """Counts and NME of faces by the names that they are told apart by; those without a name are left out."""
    names = [name_of(face) for face in faces]
    figures = {}
    for name in sorted({name for name in names if name is not None}):
        own = [face for face, its in zip(faces, names, strict=True) if its == name]
        caught = [face for face in own if face.nme is not None]
        figures[name] = {"faces": len(own), "found": len(caught), "nme": _mean_nme(caught).get("all")}
    return figures


def _yaw_class(yaw: float | None) -> str | None:
    return None if yaw is None else f"to {next((limit for limit in YAWS if abs(yaw) <= limit), YAWS[-1])}"


def _all_ratios(faces: list[FaceResult]) -> np.ndarray:
    """(n, 2) those of all faces; one that was not found has none."""
    return np.concatenate([np.zeros((0, 2)), *(face.ratios for face in faces)])


def _calibration(caught: list[FaceResult]) -> dict[str, float] | None:
    """Shares of errors within one standard deviation along the axis of the larger spread, and of the smaller."""
    ratios = _all_ratios(caught)
    if not len(ratios):
        return None
    along, across = (ratios <= 1).mean(0)
    return {"along": float(along), "across": float(across)}


def _mean_shape_nme(faces: list[FaceResult]) -> dict[str, float] | None:
    """NME of the mean of all true shapes, each in its true frame: what a detector of frames alone would have."""
    if not faces:
        return None
    shapes = np.array([face.shape for face in faces])
    errors = np.linalg.norm(shapes - shapes.mean(0), axis=2)
    shares = 100 * errors / np.linalg.norm(np.ptp(shapes, axis=1), axis=1)[:, None]
    parts = {name: list(part) for name, part in PARTS.items() if max(part) < COUNT} | {"all": list(range(COUNT))}
    return {name: float(shares[:, part].mean()) for name, part in parts.items()}
