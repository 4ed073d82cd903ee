"""What is held before faces in pictures."""

import cv2
import numpy as np

from caricli.methods.pictures.background import random_colour
from caricli.structures.parsing import Region


def hold_before(
    image: np.ndarray, region: np.ndarray, points: np.ndarray, skin: np.ndarray, generator: np.random.Generator
) -> None:
    """Draw a hand, a microphone or a thing of any shape over a part of a face, into both pictures.

    image: (S, S, 3) float32 linear light. region: (S, S) uint8. points: (L, 2) pixels, landmarks. skin: (3,) linear.
    """
    box = np.ptp(points[:68], axis=0).max()
    mask = np.zeros(region.shape, np.uint8)
    target = points[int(generator.integers(0, 68))] + generator.normal(0, 0.08, 2) * box
    kind = generator.choice(["hand", "microphone", "thing"], p=[0.5, 0.25, 0.25])
    if kind == "hand":
        colour = skin * generator.uniform(0.8, 1.2)
        _hand(mask, target, 0.55 * box * generator.uniform(0.6, 1.2), generator)
    elif kind == "microphone":
        colour = np.full(3, generator.uniform(0.02, 0.3))
        target = points[57] + [generator.normal(0, 0.2) * box, generator.uniform(0.0, 0.35) * box]
        _stick(mask, target, 0.11 * box, generator)
    else:
        colour = random_colour(generator)
        corners = target + generator.normal(0, 0.16 * box, (int(generator.integers(3, 8)), 2))
        cv2.fillConvexPoly(mask, cv2.convexHull(np.round(corners).astype(np.int32)), 255, cv2.LINE_AA)
    # Brighter in the middle, dark at its border: it is round.
    inside = cv2.distanceTransform((mask > 127).astype(np.uint8), cv2.DIST_L2, 3)
    light = 0.45 + 0.55 * np.clip(inside / max(0.04 * box, 1), 0, 1)
    share = (mask / 255.0)[..., None]
    image[:] = image * (1 - share) + (colour * light[..., None]) * share
    region[mask > 127] = Region.OTHER


def _hand(mask: np.ndarray, wrist: np.ndarray, length: float, generator: np.random.Generator) -> None:
    """A palm and fingers."""
    turn = generator.uniform(0, 2 * np.pi)
    forward = np.array([np.cos(turn), np.sin(turn)])
    aside = np.array([-forward[1], forward[0]])
    palm = wrist + 0.35 * length * forward
    ends = [(wrist - 1.2 * length * forward, palm, 0.3)]
    bend = generator.uniform(0.25, 1.0)
    for k in range(4):
        base = palm + 0.2 * length * forward + (k - 1.5) * 0.13 * length * aside
        tip = base + bend * length * (0.5 - 0.05 * abs(k - 1.2)) * (forward + 0.12 * (k - 1.5) * aside)
        ends.append((base, tip, 0.12))
    ends.append((palm, palm + 0.4 * length * (0.6 * forward - generator.choice([-1, 1]) * aside), 0.14))
    for start, end, width in ends:
        cv2.line(mask, _pixel(start), _pixel(end), 255, max(1, round(width * length)), cv2.LINE_AA)
    cv2.circle(mask, _pixel(palm), max(1, round(0.27 * length)), 255, -1, cv2.LINE_AA)


def _stick(mask: np.ndarray, head: np.ndarray, radius: float, generator: np.random.Generator) -> None:
    """A ball on a handle."""
    turn = np.pi / 2 + generator.normal(0, 0.5)
    end = head + 5 * radius * np.array([np.cos(turn), np.sin(turn)])
    cv2.line(mask, _pixel(head), _pixel(end), 255, max(1, round(1.1 * radius)), cv2.LINE_AA)
    cv2.circle(mask, _pixel(head), max(1, round(radius)), 255, -1, cv2.LINE_AA)


def _pixel(point: np.ndarray) -> tuple[int, int]:
    return round(float(point[0])), round(float(point[1]))
