"""What caricaturists do to a face, as moves of its 81 landmarks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from caricli.structures.landmarks import (
    BROW_LEFT,
    BROW_RIGHT,
    BROWS,
    CHEEKBONES,
    COUNT,
    EAR_LEFT,
    EAR_RIGHT,
    EXTRA,
    EYE_LEFT,
    EYE_RIGHT,
    EYES,
    FOREHEAD,
    JAW,
    MOUTH,
    NOSE,
    POINT_NAMES,
    TEMPLES,
)

POINTS = COUNT + len(EXTRA)
"""Landmarks that parts are moved by."""

SPREAD = {
    "chin_height": 0.22, "mouth_height": 0.20, "lip_gap": 0.22, "nose_height": 0.16, "eye_height": 0.16,
    "forehead_height": 0.15, "chin_width": 0.20, "jaw_width": 0.17, "cheek_width": 0.12, "temple_width": 0.10,
    "crown_width": 0.06, "inner_width": 0.05, "chin_forward": 0.035, "nose_size": 0.24, "nose_width": 0.13,
    "nose_length": 0.12, "nose_depth": 0.12, "nose_droop": 0.035, "nose_hump": 0.012, "mouth_width": 0.22,
    "mouth_open": 0.15, "mouth_smile": 0.022, "mouth_forward": 0.015, "eye_size": 0.22, "eye_open": 0.14,
    "eye_apart": 0.018, "eye_slant": 0.12, "eye_asymmetry": 0.05, "brow_lift": 0.022, "brow_slant": 0.16,
    "brow_length": 0.10, "brow_asymmetry": 0.010, "ear_size": 0.14, "ear_out": 0.014, "ear_lift": 0.012,
    "cheek_out": 0.020, "lean": 0.012,
}  # fmt: skip
"""Standard deviations of the random changes: logarithms of factors, or shares of the face's height where a length."""

NAMES = tuple(SPREAD)

LEANING = {"nose_depth": -0.3, "nose_width": -0.06, "nose_droop": -0.008, "ear_size": -0.12, "ear_out": -0.006}
"""Means of the random changes: curvature exaggeration only ever enlarges noses and ears; the parts lean the other way,
so that the mean is a face."""


@dataclass(frozen=True)
class PartSettings:
    """How parts are changed at random.

    bold_share: of the changes are bold, the others timid; bold, timid: factors of their standard deviations. limit: of
    a draw, in standard deviations before them: beyond it faces tear.
    """

    bold_share: float = 0.35
    bold: float = 1.45
    timid: float = 0.55
    limit: float = 2.2


@dataclass(frozen=True)
class HandSettings:
    """The unsteady hand: a smooth random field over the face.

    deviation, length: standard deviation and correlation length, in heights of the face. asymmetry: share of the field
    that each side has for itself.
    """

    deviation: float = 0.022
    length: float = 0.075
    asymmetry: float = 0.4


_PARTS = PartSettings()
_HAND = HandSettings()

_MIN_LIP_GAP = 0.6
"""Least distance between nose and upper lip, and"""
_MIN_CHIN = 0.5
"""between lower lip and chin, as shares of what they were: parts that grew push the others on."""

_CHIN = slice(4, 13)
_CHIN_SHARES = np.array([0.15, 0.4, 0.7, 0.95, 1.0, 0.95, 0.7, 0.4, 0.15])
"""The part of the jaw that follows the chin down, and how far; likewise forwards:"""
_CHIN_TIP = slice(5, 12)
_CHIN_TIP_SHARES = np.array([0.3, 0.6, 0.9, 1.0, 0.9, 0.6, 0.3])

_BRIDGE_HUMP = (28, 29)
_DROOPING_TIP = (29, 30)

_CROWN = POINT_NAMES["forehead"]
_ROOT = POINT_NAMES["nose_root"]
_BASE = POINT_NAMES["nose_base"]
_UPPER_LIP = POINT_NAMES["upper_lip"]
_LOWER_LIP = POINT_NAMES["lower_lip"]
_CHIN_POINT = POINT_NAMES["chin"]


@dataclass(frozen=True)
class Side:
    """One half of the face. sign: of the subject's x on it."""

    eye: range
    brow: range
    ear: range
    sign: int


_SIDES = (Side(EYE_RIGHT, BROW_RIGHT, EAR_RIGHT, -1), Side(EYE_LEFT, BROW_LEFT, EAR_LEFT, 1))


def random_part_changes(generator: np.random.Generator, strength: float = 1.0) -> np.ndarray:
    """Draw how a caricaturist would change a face: a few parts boldly, the others a little.

    strength: multiplies all changes.
    Returns (len(NAMES),) changes in the units of ``SPREAD``.
    """
    bold = np.where(generator.random(len(NAMES)) < _PARTS.bold_share, _PARTS.bold, _PARTS.timid)
    draw = np.clip(bold * generator.normal(size=len(NAMES)), -_PARTS.limit, _PARTS.limit)
    return strength * draw * np.array(list(SPREAD.values())) + [LEANING.get(name, 0.0) for name in NAMES]


def random_hand(landmarks: np.ndarray, generator: np.random.Generator, strength: float = 1.0) -> np.ndarray:
    """Draw small coherent moves of all landmarks, mostly symmetric: what no named part explains.

    landmarks: (81, 3) of the face, metres. strength: multiplies the moves.
    Returns (81, 3) metres.
    """
    height = landmarks[_CROWN, 1] - landmarks[_CHIN_POINT, 1]
    mirrored = np.concatenate([landmarks, landmarks * [-1, 1, 1]])
    distance = np.linalg.norm(mirrored[:, None] - mirrored[None], axis=-1) / (_HAND.length * height)
    correlation = np.exp(-0.5 * distance**2) + 1e-6 * np.eye(2 * POINTS)
    field = np.linalg.cholesky(correlation) @ generator.normal(size=(2 * POINTS, 3))
    own = field[:POINTS]
    other = field[POINTS:] * [-1, 1, 1]
    mixed = (own + other) / np.sqrt(2) * (1 - _HAND.asymmetry) + own * _HAND.asymmetry
    return strength * _HAND.deviation * height * mixed


def move_parts(landmarks: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """Apply part changes to landmarks.

    The face is first divided by height (chin, mouth, lip gap, nose, eyes, forehead), each division stretched, so that
    parts make room for each other; then the outline gets a width profile; then nose, mouth, eyes, brows and ears are
    scaled and moved about their own centres.

    landmarks: (81, 3) metres, face frame. changes: (len(NAMES),).
    Returns (81, 3). Raises ValueError for another number of landmarks.
    """
    if landmarks.shape != (POINTS, 3):
        raise ValueError(f"expected {POINTS} landmarks, found {landmarks.shape}")
    mover = _PartMover(landmarks, dict(zip(NAMES, changes, strict=True)))
    mover.stretch_heights()
    mover.widen_outline()
    mover.lean()
    mover.move_nose()
    mover.move_mouth()
    mover.move_chin()
    for side in _SIDES:
        mover.move_eye_and_brow(side)
        mover.move_ear(side)
    mover.move_cheekbones()
    return mover.moved


class _PartMover:
    """Landmarks on their way from one face to another; its methods move ``moved`` in turn."""

    def __init__(self, landmarks: np.ndarray, changes: Mapping[str, float]) -> None:
        self.given = landmarks
        self.changes = changes
        self.moved = landmarks.copy()
        self.height = landmarks[_CROWN, 1] - landmarks[_CHIN_POINT, 1]
        self.front = np.array([0.0, 0.0, self.height])

    def stretch_heights(self) -> None:
        """Give every landmark its new height."""
        self.stretched = _stretch_heights(self.given, self.changes)
        self.moved[:, 1] = self.stretched

    def widen_outline(self) -> None:
        """Scale the outline by a smooth profile over the height; ears and inner parts follow it."""
        given = self.given
        moved = self.moved
        middle = given[_ROOT, 0]
        profile = _width_profile((given[:, 1] - given[_CHIN_POINT, 1]) / self.height, self.changes)
        outline = np.r_[JAW, FOREHEAD, CHEEKBONES, TEMPLES]
        moved[outline, 0] = middle + (given[outline, 0] - middle) * profile[outline]
        for ear in (EAR_RIGHT, EAR_LEFT):
            moved[ear, 0] += np.mean((given[ear, 0] - middle) * (profile[ear] - 1))
        inner = np.r_[BROWS, NOSE, EYES, MOUTH]
        own_width = (given[inner, 0] - middle) * np.exp(self.changes["inner_width"])
        moved[inner, 0] = middle + own_width * (0.6 + 0.4 * profile[inner])

    def lean(self) -> None:
        """Turn the lower face to one side."""
        given = self.given
        level = (given[_BASE, 1] - given[:, 1]) / (given[_BASE, 1] - given[_CHIN_POINT, 1])
        self.moved[:, 0] += self.changes["lean"] * self.height * np.clip(level, -1, 1)

    def move_nose(self) -> None:
        """Scale the nose about its root, let its tip droop, raise its bridge."""
        moved = self.moved
        changes = self.changes
        size = changes["nose_size"]
        width = size + changes["nose_width"]
        length = 0.7 * size + changes["nose_length"]
        depth = 1.1 * size + changes["nose_depth"]
        _scale(moved, NOSE, moved[_ROOT], (width, length, depth))
        down = np.array([0.0, -self.height, 0.0])
        moved[list(_DROOPING_TIP)] += changes["nose_droop"] * (down - 0.4 * self.front)
        moved[list(_BRIDGE_HUMP)] += changes["nose_hump"] * self.front

    def move_mouth(self) -> None:
        """Scale and bend the mouth, below the nose and around the teeth."""
        given = self.given
        moved = self.moved
        changes = self.changes
        # A nose that grew pushes the mouth ahead of it, and a little forwards.
        push = moved[_BASE] - given[_BASE] - [0.0, self.stretched[_BASE] - given[_BASE, 1], 0.0]
        widening = changes["mouth_width"]
        _scale(moved, MOUTH, moved[MOUTH].mean(0), (widening, changes["mouth_open"], 0.1 * widening))
        moved[MOUTH] += [0.0, 0.6, 0.25] * push + changes["mouth_forward"] * self.front
        side = np.abs(moved[MOUTH, 0] - moved[MOUTH, 0].mean()) / max(np.ptp(moved[MOUTH, 0]) / 2, 1e-9)
        moved[MOUTH, 1] += changes["mouth_smile"] * self.height * side**2
        # The upper lip stays below the nose, whatever the two have grown to.
        gap = moved[_BASE, 1] - moved[_UPPER_LIP, 1]
        moved[MOUTH, 1] -= max(_MIN_LIP_GAP * (given[_BASE, 1] - given[_UPPER_LIP, 1]) - gap, 0.0)
        # A wide mouth bends back around the teeth.
        moved[MOUTH, 2] -= 0.5 * max(np.expm1(widening), 0) * np.ptp(given[MOUTH, 2]) * side**2

    def move_chin(self) -> None:
        """Push the chin forwards, and down where the mouth needs room."""
        given = self.given
        moved = self.moved
        moved[_CHIN_TIP] += self.changes["chin_forward"] * self.front * _CHIN_TIP_SHARES[:, None]
        room = moved[_LOWER_LIP, 1] - moved[_CHIN_POINT, 1]
        wanted = _MIN_CHIN * (given[_LOWER_LIP, 1] - given[_CHIN_POINT, 1])
        moved[_CHIN, 1] -= max(wanted - room, 0.0) * _CHIN_SHARES

    def move_eye_and_brow(self, side: Side) -> None:
        """Scale, slant and move an eye, and the brow above it, which makes room."""
        moved = self.moved
        changes = self.changes
        eye = side.eye
        brow = side.brow
        size = changes["eye_size"] + side.sign * changes["eye_asymmetry"]
        before = np.ptp(moved[eye, 1])
        _scale(moved, eye, moved[eye].mean(0), (size, size + changes["eye_open"], 0.3 * size))
        moved[eye, 1] += side.sign * changes["eye_slant"] * (moved[eye, 0] - moved[eye, 0].mean())
        grown = (np.ptp(moved[eye, 1]) - before) / 2
        moved[np.r_[eye, brow], 0] += side.sign * changes["eye_apart"] * self.height
        _scale(moved, brow, moved[brow].mean(0), (changes["brow_length"], 0.0, 0.0))
        lift = (changes["brow_lift"] + side.sign * changes["brow_asymmetry"]) * self.height
        # A brow follows an eye that shrank only half of the way.
        moved[brow, 1] += lift + max(grown, 0.5 * grown)
        moved[brow, 1] += side.sign * changes["brow_slant"] * (moved[brow, 0] - moved[brow, 0].mean())

    def move_ear(self, side: Side) -> None:
        """Scale and move an ear; one that stands out does so most in its middle."""
        moved = self.moved
        size = self.changes["ear_size"]
        out = self.changes["ear_out"]
        _scale(moved, side.ear, moved[side.ear].mean(0), (0.5 * size, size, size))
        moved[side.ear] += [side.sign * out * self.height, self.changes["ear_lift"] * self.height, 0.0]
        moved[side.ear[1], 0] += side.sign * max(out, 0.0) * self.height

    def move_cheekbones(self) -> None:
        """Push the cheekbones forwards."""
        self.moved[CHEEKBONES, 2] += self.changes["cheek_out"] * self.height


def _stretch_heights(landmarks: np.ndarray, changes: Mapping[str, float]) -> np.ndarray:
    """New heights (81,): the divisions of the face between seven levels, each stretched by its own factor."""
    lower = landmarks[[_CHIN_POINT, _LOWER_LIP, _UPPER_LIP, _BASE, _ROOT], 1]
    brow = landmarks[BROWS, 1].mean()
    levels = np.maximum.accumulate(np.r_[lower, brow, landmarks[_CROWN, 1]] + 1e-6 * np.arange(7))
    names = ("chin_height", "mouth_height", "lip_gap", "nose_height", "eye_height", "forehead_height")
    stretch = np.array([changes[n] for n in names])
    # Half of a common stretch is dropped: a longer face is one caricature of many.
    gaps = np.diff(levels) * np.exp(stretch - 0.5 * stretch.mean())
    moved = np.r_[0.0, np.cumsum(gaps)]
    # Heights stay relative to the root of the nose; beyond the ends points keep their distance to the last level.
    moved += levels[4] - moved[4]
    heights = landmarks[:, 1]
    inside = np.interp(heights, levels, moved)
    return inside + np.minimum(heights - levels[0], 0) + np.maximum(heights - levels[-1], 0)


def _width_profile(level: np.ndarray, changes: Mapping[str, float]) -> np.ndarray:
    """Factors of the width (81,) at levels (81,), 0 at the chin and 1 at the crown: a smooth bump for each change."""
    bumps = (
        ("chin_width", 0.0, 0.12),
        ("jaw_width", 0.22, 0.16),
        ("cheek_width", 0.48, 0.2),
        ("temple_width", 0.72, 0.2),
        ("crown_width", 1.0, 0.22),
    )
    return np.exp(sum(changes[name] * np.exp(-(((level - centre) / width) ** 2)) for name, centre, width in bumps))


def _scale(points: np.ndarray, ids: Sequence[int], pivot: np.ndarray, logarithms: tuple[float, float, float]) -> None:
    """Scale some of the points in place about a pivot, by a factor for each axis."""
    fixed = pivot.copy()
    points[ids] = fixed + (points[ids] - fixed) * np.exp(logarithms)
