"""Faces in pictures: those that are there, and those that were found."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from caricli.errors import shown
from caricli.structures.landmarks import COUNT, EYES, MOUTH, Landmarks


@dataclass(frozen=True, eq=False)
class FaceFrame:
    """Where a face is in a picture: a square that is turned as the face is.

    centre: (2,) pixels. side: pixels. roll: radians, clockwise as the picture is seen, 0 where the face is upright.
    """

    centre: np.ndarray
    side: float
    roll: float

    @staticmethod
    def of(points: np.ndarray) -> "FaceFrame":
        """The frame of landmarks (68 or 81, 2): the smallest that holds the points of iBUG, from eyes to mouth."""
        points = np.asarray(points, np.float64)[:COUNT]
        down = points[MOUTH].mean(0) - points[EYES].mean(0)
        roll = float(np.arctan2(-down[0], down[1]))
        axes = turn_axes(roll)
        local = points @ axes.T
        low = local.min(0)
        high = local.max(0)
        return FaceFrame((low + high) / 2 @ axes, float((high - low).max()), roll)

    def matrix(self, size: int, share: float) -> np.ndarray:
        """(2, 3) affine map from the picture to a window of (size, size) pixels in which the face is upright.

        share: of the window's side to the face's.
        """
        scale = size / (share * self.side)
        linear = scale * turn_axes(self.roll)
        return np.column_stack([linear, (size - 1) / 2 - linear @ self.centre])

    @cached_property
    def corners(self) -> np.ndarray:
        """(4, 2) pixels, clockwise from the top left of the face."""
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * self.side / 2
        return square @ turn_axes(self.roll) + self.centre


def turn_axes(roll: float) -> np.ndarray:
    """(2, 2) rows: the directions to the right and down of what is turned clockwise by an angle in radians."""
    cosine = np.cos(roll)
    sine = np.sin(roll)
    return np.array([[cosine, sine], [-sine, cosine]])


@dataclass(frozen=True, eq=False)
class DetectedFace:
    """A face in a picture.

    frame: FaceFrame. score: 0 to 1, how sure it is that this is a face. landmarks: 81 Landmarks with spreads and
    visibility.
    """

    frame: FaceFrame
    score: float
    landmarks: Landmarks

    @property
    def spread(self) -> float:
        """How far its known landmarks may be off: root mean square of their spreads, a share of their diagonal."""
        assert self.landmarks.spreads is not None
        own = self.landmarks.spreads[self.landmarks.known]
        return float(np.sqrt(np.trace(own, axis1=1, axis2=2).mean())) / self.landmarks.diagonal


@dataclass(frozen=True, eq=False)
class Detection:
    """What a picture shows.

    faces: the largest first. regions: (H, W) uint8 values of Region.
    """

    faces: list[DetectedFace]
    regions: np.ndarray


@dataclass(frozen=True, eq=False)
class SeenFace:
    """What a picture shows, where one face is what it is of.

    face: DetectedFace, the largest without doubt, or the largest. regions: (H, W) uint8 values of Region, of the whole
    picture. others: faces beside it. doubt: why it may be wrong, a phrase, or None where nothing speaks against it.
    """

    face: DetectedFace
    regions: np.ndarray
    others: int = 0
    doubt: str | None = None

    @property
    def landmarks(self) -> Landmarks:
        """Its 81 Landmarks with spreads and visibility."""
        return self.face.landmarks

    def figures(self) -> dict[str, Any]:
        """What reports say of it, as JSON."""
        own = {"score": self.face.score, "spread": self.face.spread, "known": int(self.landmarks.known.sum())}
        return own | {"other_faces": self.others, "doubt": self.doubt}


@dataclass(frozen=True, eq=False)
class ParsedPicture:
    """A picture, and what it shows.

    pixels: (H, W, 3) uint8. regions: (H, W) uint8 values of Region, or None where nobody said.
    """

    pixels: np.ndarray
    regions: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class FacePicture:
    """The landmarks of a face, and the picture that they belong to.

    landmarks: Landmarks. pixels: (H, W, 3) uint8, or None where there is no picture. seen: SeenFace that the landmarks
    are of, or None where they were given. regions: (H, W) uint8 values of Region, or None where nobody said what the
    picture shows.
    """

    landmarks: Landmarks
    pixels: np.ndarray | None = None
    seen: SeenFace | None = None
    regions: np.ndarray | None = None

    @property
    def parsed(self) -> ParsedPicture | None:
        """The picture, where there is one."""
        return None if self.pixels is None else ParsedPicture(self.pixels, self.regions)

    def figures(self) -> dict[str, Any]:
        """What reports say of a face that was seen, as JSON."""
        return {} if self.seen is None else {"detected": self.seen.figures()}

    def note(self, name: object) -> str | None:
        """What is worth knowing of a face that was seen in a picture of a name, or None."""
        if self.seen is None:
            return None
        rank = "the largest" if self.seen.doubt else "the largest sure one"
        others = f"took {rank} of {self.seen.others + 1} faces" if self.seen.others else None
        doubt = f"the face is doubtful: {self.seen.doubt}" if self.seen.doubt else None
        notes = "; ".join(note for note in (others, doubt) if note)
        return f"{shown(name)}: {notes}" if notes else None


@dataclass(frozen=True, eq=False)
class MarkedPicture:
    """A picture and what is true of it.

    pixels: (H, W, 3) uint8. regions: (H, W) uint8. landmarks: (M, 81, 2) pixels. visible: (M, 81) bool.
    """

    pixels: np.ndarray
    regions: np.ndarray
    landmarks: np.ndarray
    visible: np.ndarray
