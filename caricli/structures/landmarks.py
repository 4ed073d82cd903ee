"""2D landmarks of one picture, and the one table of their layouts: iBUG-68, and with 13 further points 81.

iBUG counts from the left of the picture; left and right are the subject's.
"""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.limits import MAX_COORDINATE
from caricli.structures.checks import are_apart, coordinate_problem, refuse

SCHEMES = {68: "ibug68", 81: "ibug68+13"}
"""Names of the layouts by their number of points."""

COUNT = 68
"""Points of iBUG."""

JAW = range(0, 17)
BROW_RIGHT = range(17, 22)
BROW_LEFT = range(22, 27)
BRIDGE = range(27, 31)
NOSTRILS = range(31, 36)
EYE_RIGHT = range(36, 42)
EYE_LEFT = range(42, 48)
LIPS = range(48, 60)
LIPS_INSIDE = range(60, 68)
FOREHEAD = range(68, 71)
EAR_RIGHT = range(71, 74)
EAR_LEFT = range(74, 77)
CHEEKBONES = range(77, 79)
TEMPLES = range(79, 81)

BROWS = range(17, 27)
NOSE = range(27, 36)
EYES = range(36, 48)
MOUTH = range(48, 68)
EXTRA = range(68, 81)
INNER = range(17, 68)
"""The 51 points of brows, nose, eyes and mouth."""

PARTS = {"jaw": JAW, "brows": BROWS, "nose": NOSE, "eyes": EYES, "mouth": MOUTH, "extra": EXTRA}
"""What errors are told apart by."""

GROUPS = {
    "jaw": JAW, "brow_right": BROW_RIGHT, "brow_left": BROW_LEFT, "nose": NOSE, "eye_right": EYE_RIGHT,
    "eye_left": EYE_LEFT, "mouth": MOUTH, "forehead": FOREHEAD, "ear_right": EAR_RIGHT, "ear_left": EAR_LEFT,
    "cheekbones": CHEEKBONES, "temples": TEMPLES,
}  # fmt: skip
"""What a hand moves together; every point is in one of them."""

POLYLINES = (JAW, BROW_RIGHT, BROW_LEFT, BRIDGE, NOSTRILS)
RINGS = (EYE_RIGHT, EYE_LEFT, LIPS, LIPS_INSIDE)
"""Open and closed lines that the points stand on, as they are drawn."""

OUTLINE = (*JAW, *reversed(BROWS))
"""Around the face: along the jaw, back along the brows."""

UPPER_LID = {"left": (42, 43, 44, 45), "right": (39, 38, 37, 36)}
LOWER_LID = {"left": (42, 47, 46, 45), "right": (39, 40, 41, 36)}
"""From the inner to the outer corner of an eye."""

UPPER_LIP = (48, 49, 50, 51, 52, 53, 54)
LOWER_LIP = (48, 59, 58, 57, 56, 55, 54)
UPPER_LIP_INSIDE = (60, 61, 62, 63, 64)
LOWER_LIP_INSIDE = (60, 67, 66, 65, 64)
"""From the right to the left corner of the mouth."""

LID_PAIRS = ((37, 41), (38, 40), (43, 47), (44, 46))
LIP_PAIRS = ((61, 67), (62, 66), (63, 65))
"""Upper and lower points that may meet, but not pass each other."""

MOUTH_CORNERS = ((48, 60), (54, 64))
"""Outer and inner corner, which many mark in one place."""

EXTRA_NAMES = (
    *("forehead_right", "forehead_centre", "forehead_left", "ear_right_top", "ear_right_outer", "ear_right_lobe"),
    *("ear_left_top", "ear_left_outer", "ear_left_lobe", "cheekbone_right", "cheekbone_left", "temple_right"),
    "temple_left",
)
POINT_NAMES = {
    "nose_tip": 30, "nose_root": 27, "nose_base": 33, "nostril_right": 31, "nostril_left": 35, "chin": 8,
    "jaw_right": 4, "jaw_left": 12, "mouth_corner_right": 48, "mouth_corner_left": 54, "upper_lip": 51, "lower_lip": 57,
    "brow_right": 19, "brow_left": 24, "brow_inner_right": 21, "brow_inner_left": 22, "eye_outer_right": 36,
    "eye_inner_right": 39, "eye_inner_left": 42, "eye_outer_left": 45, "forehead": 69, "ear_right": 72, "ear_left": 75,
} | {name: number for number, name in enumerate(EXTRA_NAMES, COUNT)}  # fmt: skip
"""Numbers of points by their names."""

MIRRORED = (
    *range(16, -1, -1), *range(26, 16, -1), 27, 28, 29, 30, 35, 34, 33, 32, 31, 45, 44, 43, 42, 47, 46, 39, 38, 37, 36,
    41, 40, 54, 53, 52, 51, 50, 49, 48, 59, 58, 57, 56, 55, 64, 63, 62, 61, 60, 67, 66, 65, 70, 69, 68, 74, 75, 76, 71,
    72, 73, 78, 77, 80, 79,
)  # fmt: skip
"""Of each of the 81 points, the one in whose place it stands in a mirrored picture."""

FEWEST = 8
"""Points that must be known."""


def group_of(number: int) -> str:
    """The name in GROUPS of the group that a point is in."""
    return next(name for name, numbers in GROUPS.items() if number in numbers)


def point_label(number: int) -> str:
    """What a point is called where people read it: "nose tip", "right eye 2 of 6"."""
    name = next((name for name, other in POINT_NAMES.items() if other == number), None)
    if name is not None:
        return name.replace("_", " ")
    group = group_of(number)
    numbers = list(GROUPS[group])
    part, _, side = group.partition("_")
    return f"{side} {part}".strip() + f" {numbers.index(number) + 1} of {len(numbers)}"


_INSIDE = 0.5  # least share of the points inside the picture
_SMALLEST = 8.0  # least diagonal of a face, pixels


def fitted_problem(landmarks: np.ndarray) -> str | None:
    """Whether landmarks that were fitted, pixels, are not those of a layout, all finite."""
    if landmarks.shape not in [(count, 2) for count in SCHEMES]:
        return f"landmarks: expected the shape (68,2) or (81,2), found {landmarks.shape}"
    return coordinate_problem("landmarks", landmarks)


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Landmarks of one picture.

    points: (68, 2) or (81, 2) float64, pixels, origin at the top left, y down; a NaN row where a point is not known.
    image_size: (width, height) in pixels, or None where it is not known. spreads: (L, 2, 2) covariances of their
    errors, square pixels, or None where nothing is known of them; NaN where a point is not known. visibility: (L,) from
    0 to 1, how sure it is that nothing hides a point, or None. slides: (L, 2) pixels, how far along its line from where
    people mark a point the head's own landmark lies, as a detector sees it, or None where nothing is known of that.
    Raises InputError for another number of points, a coordinate that is not finite, fewer than FEWEST known points, all
    of them in one place, spreads that are no covariances, or, where the size is known, points that do not belong to
    such a picture.
    """

    points: np.ndarray
    image_size: tuple[int, int] | None = None
    spreads: np.ndarray | None = None
    visibility: np.ndarray | None = None
    slides: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check that they can be the landmarks of a face."""
        points = np.asarray(self.points, np.float64)
        object.__setattr__(self, "points", points)
        if points.shape not in [(count, 2) for count in SCHEMES]:
            refuse(f"expected 68 or 81 points, found {len(points)}")
        given = ~np.isnan(points).all(axis=1)
        near = np.all(np.abs(points) <= MAX_COORDINATE, axis=1)
        if not near[given].all():
            k = int(np.argmax(given & ~near))
            refuse(f"point {k}: expected finite coordinates, found {points[k].tolist()}")
        if given.sum() < FEWEST:
            refuse(f"expected at least {FEWEST} known points, found {given.sum()}")
        if not are_apart(points[given]):
            refuse("expected the points of a face, found all of them in one place")
        if self.image_size is not None:
            self.check_inside(self.image_size)
        if self.spreads is not None:
            _check_spreads(self.spreads, self.known)
        if self.visibility is not None:
            given = np.asarray(self.visibility)
            if given.shape != (len(points),) or not ((given >= 0) & (given <= 1)).all():
                refuse(f"expected a visibility from 0 to 1 of every point, found {given.shape}")
        if self.slides is not None:
            given = np.asarray(self.slides)
            if given.shape != points.shape:
                refuse(f"expected a slide of every point, found {given.shape}")
            near = (np.abs(given) <= self.diagonal).all(axis=1)
            if not near.all():
                k = int(np.argmin(near))
                refuse(f"point {k}: expected a slide no farther than the face is large, found {given[k].tolist()}")

    @property
    def known(self) -> np.ndarray:
        """(L,) bool: points that are known."""
        return np.isfinite(self.points).all(axis=1)

    @property
    def head_points(self) -> np.ndarray:
        """(L, 2) pixels, where the head's own landmarks are, to which faces are fitted."""
        return self.points if self.slides is None else self.points + self.slides

    @property
    def diagonal(self) -> float:
        """Diagonal of the known points' bounding box, pixels: what errors are measured against."""
        return float(np.linalg.norm(np.ptp(self.points[self.known], axis=0)))

    def first(self, count: int) -> "Landmarks":
        """The first 68 or 81 of them."""
        columns = (self.spreads, self.visibility, self.slides)
        shares = (None if values is None else values[:count] for values in columns)
        return Landmarks(self.points[:count], self.image_size, *shares)

    def check_inside(self, size: tuple[int, int]) -> None:
        """Refuse landmarks far outside a picture of (width, height) pixels.

        Raises InputError when a point lies more than one picture's size beyond its border, fewer than half of them lie
        inside, or the face is smaller than a few pixels.
        """
        image = np.array(size, np.float64)
        points = self.points[self.known]
        inside = ((points >= 0) & (points <= image)).all(axis=1).mean()
        if inside < _INSIDE or self.diagonal < _SMALLEST:
            raise InputError(
                f"expected the landmarks of a face in the {size[0]} x {size[1]} image, found {100 * inside:.0f} % of "
                f"them inside, {self.diagonal:.3g} pixels across"
            )
        outside = ((self.points < -image) | (self.points > 2 * image)).any(axis=1)
        if outside.any():
            k = int(np.argmax(outside))
            expected = f"a place in or near the {size[0]} x {size[1]} image"
            raise InputError(f"point {k}: expected {expected}, found {self.points[k].tolist()}")


def _check_spreads(spreads: np.ndarray, known: np.ndarray) -> None:
    """Refuse what are no covariances (L, 2, 2) of the known points."""
    if spreads.shape != (len(known), 2, 2):
        refuse(f"expected a spread of every point, found {spreads.shape}")
    own = spreads[known]
    sound = (own[:, 0, 0] > 0) & (np.linalg.det(own) > 0) & (own[:, 0, 1] == own[:, 1, 0])
    if not sound.all():
        k = int(np.flatnonzero(known)[np.argmin(sound)])
        refuse(f"point {k}: expected a covariance, found {spreads[k].tolist()}")
