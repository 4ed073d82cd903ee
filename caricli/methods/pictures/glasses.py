"""Glasses that people wear in pictures."""

import numpy as np

from caricli.methods.pictures.piece import Piece, make_piece, seen_from_both_sides
from caricli.structures.landmarks import BROWS, EAR_LEFT, EAR_RIGHT, EYE_LEFT, EYE_RIGHT, EYES
from caricli.structures.parsing import Region

SEGMENTS = 40
"""Of a rim."""


def random_glasses(marks: np.ndarray, dark: bool, generator: np.random.Generator) -> list[Piece]:
    """Draw spectacles: rims of any shape, a bridge, arms to the ears, lenses where they are dark.

    marks: (81, 3) metres, landmarks of the face. Returns the Pieces of them, seen from both sides.
    """
    right = marks[list(EYE_RIGHT)].mean(0)
    left = marks[list(EYE_LEFT)].mean(0)
    apart = float(np.linalg.norm(left - right))
    across = (left - right) / apart
    up = np.cross([0.0, 0.0, 1.0], across)
    near = marks[[*EYES, *BROWS, 27, 28]]
    depth = near[:, 2].max() + 0.05 * apart
    width = apart * generator.uniform(0.36, 0.47)
    height = width * generator.uniform(0.5, 1.05)
    thick = width * generator.uniform(0.05, 0.2)
    power = generator.uniform(2, 4.5)
    colour = generator.random(3) ** 2 * (0.15 if generator.random() < 0.6 else 1.0)
    low = generator.uniform(-0.3, 0.1) * height
    pieces = []
    for eye, ears in ((right, EAR_RIGHT), (left, EAR_LEFT)):
        middle = np.array([eye[0], eye[1], depth]) + low * up
        ring = _superellipse(width, height, power) @ np.stack([across, up])
        share = 1 - thick / width
        pieces.append(_band(middle + ring, middle + share * ring, colour))
        outward = np.sign(eye[0] - (left + right)[0] / 2) * across
        hinge = middle + width * outward
        arm = np.stack([hinge, marks[ears[0]]])
        pieces.append(_band(arm + thick / 2 * up, arm - thick / 2 * up, colour, closed=False))
        if dark:
            pieces.append(_disc(middle, middle + share * ring - [0, 0, 0.01 * apart], generator.random(3) * 0.06))
    ends = np.stack([right + (width - thick / 2) * across, left - (width - thick / 2) * across])
    ends[:, 2] = depth
    bridge = ends + (low + 0.2 * height) * up
    return [*pieces, _band(bridge + thick / 2 * up, bridge - thick / 2 * up, colour, closed=False)]


def _superellipse(width: float, height: float, power: float) -> np.ndarray:
    """(SEGMENTS, 2) points of a superellipse of half so wide and high."""
    turn = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    x, y = np.cos(turn), np.sin(turn)
    return np.stack([width * np.sign(x) * np.abs(x) ** (2 / power), height * np.sign(y) * np.abs(y) ** (2 / power)], 1)


def _band(outer: np.ndarray, inner: np.ndarray, colour: np.ndarray, closed: bool = True) -> Piece:
    """A strip between two lines (N, 3)."""
    count = len(outer)
    first = np.arange(count if closed else count - 1)
    after = (first + 1) % count
    faces = np.concatenate(
        [np.stack([first, after, count + after], 1), np.stack([first, count + after, count + first], 1)]
    )
    return _thin(np.concatenate([outer, inner]), faces, colour)


def _disc(middle: np.ndarray, rim: np.ndarray, colour: np.ndarray) -> Piece:
    """A fan from a point (3,) to a closed line (N, 3)."""
    first = np.arange(len(rim))
    faces = np.stack([np.full(len(rim), len(rim)), first, np.roll(first, -1)], 1)
    return _thin(np.vstack([rim, middle]), faces, colour)


def _thin(vertices: np.ndarray, faces: np.ndarray, colour: np.ndarray) -> Piece:
    return seen_from_both_sides(make_piece(vertices, faces, Region.GLASSES, colour, 0.3))
