"""Semantic attributes of a face, measured on its landmarks."""

from collections.abc import Sequence

import numpy as np

from caricli.structures.landmarks import (
    BROW_LEFT,
    BROW_RIGHT,
    BROWS,
    CHEEKBONES,
    EYES,
    LID_PAIRS,
    LOWER_LIP_INSIDE,
    POINT_NAMES,
    UPPER_LIP_INSIDE,
)
from caricli.template.template import Template

QUANTILE = 0.75
"""A mesh has an attribute when it is measured above this quantile of the training meshes."""

_BINARY = ("Women", "Caricature")
"""Attributes that are one or the other: the threshold is half."""

_LEAST = 1e-9
"""Metres: below it a length is none, and nothing is divided by it."""

_UPPER_INSIDE = UPPER_LIP_INSIDE[2]
_LOWER_INSIDE = LOWER_LIP_INSIDE[2]
"""Where the lips meet in the middle."""

# Points of the jaw that have no name of their own: where face, chin and head are measured across.
_FACE_SIDES = (2, 14)
_CHIN_SIDES = (6, 10)
_JAW_ENDS = (0, 16)
_CHIN = slice(7, 10)


def measure_attributes(
    vertices: np.ndarray,
    template: Template,
    gender: float | None = None,
    age: float | None = None,
    exaggerated: bool | None = None,
) -> dict[str, float]:
    """Measure attributes under the names of WebCariA (Ji et al. 2020); larger means more of it.

    vertices: (V, 3) metres. template: with 81 landmarks. gender: 1 is female, and age: from 0 to 1, where known.
    exaggerated: where known.
    Returns numbers by names; lengths are divided by the size of the face. DoubleChin is left out where the chin's
    ``jaw_paths`` are its landmarks alone, which say nothing of what is below them.
    """
    face = _Face(vertices[template.annotation.landmarks])
    throat = [path[0] for path in template.annotation.jaw_paths[_CHIN] if len(path) > 1]
    # Datasets keep this order.
    measures = face.nose() | face.mouth() | face.eyes() | face.outline()
    if throat:
        measures["DoubleChin"] = (face.at("chin")[1] - vertices[throat, 1].mean()) / face.size
    measures |= face.brows() | face.ears()
    if gender is not None:
        measures["Women"] = gender
    if age is not None:
        measures["Youth"] = -age
        measures["Old"] = age
    if exaggerated is not None:
        measures["Caricature"] = float(exaggerated)
    return {name: float(value) for name, value in measures.items()}


class _Face:
    """Lengths on the landmarks of one face."""

    def __init__(self, points: np.ndarray) -> None:
        """points: (81, 3) metres."""
        self.points = points
        self.width = self.gap(*_FACE_SIDES)
        self.height = float(self.at("nose_root")[1] - self.at("chin")[1])
        self.size = np.sqrt(self.width * max(self.height, _LEAST))

    def at(self, name: str) -> np.ndarray:
        """(3,) the landmark of a name."""
        return self.points[POINT_NAMES[name]]

    def gap(self, first: int | str, second: int | str) -> float:
        """Distance of two landmarks, given by numbers or names."""
        ends = (POINT_NAMES[end] if isinstance(end, str) else end for end in (first, second))
        start, end = (self.points[number] for number in ends)
        return float(np.linalg.norm(start - end))

    def outline(self) -> dict[str, float]:
        """Forehead, jaw, chin, cheekbones, and how long the face is for its width."""
        points = self.points
        forehead = (self.at("forehead")[1] - self._brow_height()) / self.size
        jaw = self.gap("jaw_right", "jaw_left")
        chin = self.gap(*_CHIN_SIDES)
        cheekbones = list(CHEEKBONES)
        jaw_points = [POINT_NAMES["jaw_right"], POINT_NAMES["jaw_left"]]
        forwards = points[cheekbones, 2].mean() - points[jaw_points, 2].mean()
        return {
            "LargeForehead": forehead,
            "SmallForehead": -forehead,
            "SquareJaw": jaw / self.width + 0.5 * chin / jaw,
            "PointedChin": -chin / jaw,
            "LongChin": float(self.at("lower_lip")[1] - self.at("chin")[1]) / self.size,
            "HighCheekbones": self.gap("cheekbone_right", "cheekbone_left") / jaw + forwards / self.size,
            "RoundFace": self.width / self.height,
            "LongFace": -self.width / self.height,
        }

    def nose(self) -> dict[str, float]:
        """Size, width, length, and how hooked the nose is."""
        root = self.at("nose_root")
        tip = self.at("nose_tip")
        nostrils = self.points[[POINT_NAMES["nostril_right"], POINT_NAMES["nostril_left"]]]
        width = self.gap("nostril_right", "nostril_left")
        length = self.gap("nose_root", "nose_base")
        depth = max(tip[2] - nostrils[:, 2].mean(), _LEAST)
        nose = (width * length * depth) ** (1 / 3) / self.size
        # How far the bridge stands before the line from root to tip, and how far the tip hangs.
        bridge = self.points[POINT_NAMES["nose_root"] + 1 : POINT_NAMES["nose_tip"]]
        line = root + (tip - root) * ((bridge[:, 1] - root[1]) / (tip[1] - root[1]))[:, None]
        hook = ((bridge[:, 2] - line[:, 2]).mean() + 0.5 * (self.at("nose_base")[1] - tip[1])) / self.size
        return {
            "BigNose": nose,
            "SmallNose": -nose,
            "WideNose": width / self.size,
            "LongNose": length / self.size,
            "HookNose": hook,
        }

    def mouth(self) -> dict[str, float]:
        """Width, lips, opening, and where the corners are."""
        width = self.gap("mouth_corner_right", "mouth_corner_left")
        lips = (self.gap("upper_lip", _UPPER_INSIDE) + self.gap("lower_lip", _LOWER_INSIDE)) / 2
        heights = self.points[:, 1]
        # Lips that went through each other are less than closed.
        opening = float(heights[_UPPER_INSIDE] - heights[_LOWER_INSIDE])
        ends = [POINT_NAMES["mouth_corner_right"], POINT_NAMES["mouth_corner_left"]]
        middle = [POINT_NAMES["upper_lip"], POINT_NAMES["lower_lip"], _UPPER_INSIDE, _LOWER_INSIDE]
        corners = (heights[ends].mean() - heights[middle].mean()) / width
        return {
            "BigMouth": width / self.size,
            "SmallMouth": -width / self.size,
            "ThickLips": lips / self.size,
            "ThinLips": -lips / self.size,
            "MouthOpen": opening / self.size,
            "Smile": corners,
            "Frown": -corners,
        }

    def eyes(self) -> dict[str, float]:
        """Size, shape and distance of the eyes."""
        width = (self.gap("eye_outer_right", "eye_inner_right") + self.gap("eye_inner_left", "eye_outer_left")) / 2
        height = sum(self.gap(*pair) for pair in LID_PAIRS) / len(LID_PAIRS)
        eye = np.sqrt(width * height) / self.size
        return {
            "BigEye": eye,
            "SmallEye": -eye,
            "NarrowEye": -height / width,
            "WideSetEyes": self.gap("eye_inner_right", "eye_inner_left") / self.size,
        }

    def brows(self) -> dict[str, float]:
        """Height and arch of the brows."""
        heights = self.points[:, 1]
        ends = [BROW_RIGHT[0], BROW_RIGHT[-1], BROW_LEFT[0], BROW_LEFT[-1]]
        middles = self.at("brow_right")[1] + self.at("brow_left")[1]
        lengths = self.gap(*ends[:2]) + self.gap(*ends[2:])
        eyes = heights[EYES.start : EYES.stop].mean()
        return {
            "ArchedEyebrows": (middles - heights[ends].sum() / 2) / lengths,
            "RaisedEyebrows": (self._brow_height() - eyes) / self.size,
        }

    def ears(self) -> dict[str, float]:
        """Size of the ears, and how far they stand out."""
        right = self.gap("ear_right_top", "ear_right_lobe")
        left = self.gap("ear_left_top", "ear_left_lobe")
        return {
            "BigEar": (right + left) / 2 / self.size,
            "ProtrudingEars": self.gap("ear_right_outer", "ear_left_outer") / self.gap(*_JAW_ENDS),
        }

    def _brow_height(self) -> float:
        return self.points[BROWS.start : BROWS.stop, 1].mean()


def binary_labels(measures: np.ndarray, names: Sequence[str], training: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turn measures into labels by comparing them with the training meshes.

    measures: (N, A). names: A names. training: (N,) bool.
    Returns (labels (N, A) bool, thresholds (A,)).
    """
    thresholds = np.quantile(measures[training], QUANTILE, axis=0)
    for name in _BINARY:
        if name in names:
            thresholds[list(names).index(name)] = 0.5
    return measures > thresholds, thresholds
