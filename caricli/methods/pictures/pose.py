"""How heads stand before the camera of a picture."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.methods.pictures.settings import PoseSettings
from caricli.structures.landmarks import COUNT
from caricli.template.template import Template


@dataclass(frozen=True, eq=False)
class Pose:
    """How a head stands before the camera: a pixel is ``scale * f * (rotation @ p)[:2] + translation``.

    rotation: (3, 3) from the face's axes to the camera's. scale: pixels a metre. translation: (2,) pixels.
    perspective: f = 1 / (1 + perspective * depth), depth in heights of the head behind its middle. middle: (3,) metres,
    the point that p is counted from. height: metres, of the head.
    """

    rotation: np.ndarray
    scale: float
    translation: np.ndarray
    perspective: float
    middle: np.ndarray
    height: float

    def place(self, points: np.ndarray) -> np.ndarray:
        """(N, 3) pixels and depth, in pixels too, of points (N, 3) metres."""
        turned = (points - self.middle) @ self.rotation.T
        size = self.size_at(turned[:, 2:])
        return np.column_stack([size * turned[:, :2] + self.translation, self.scale * turned[:, 2]])

    def size_at(self, depth: np.ndarray) -> np.ndarray:
        """Pixels of a metre that is so far behind the middle, metres."""
        return self.scale / (1 + self.perspective * depth / self.height)


def random_pose(
    head: Template, size: int, filled: float, generator: np.random.Generator, settings: PoseSettings
) -> Pose:
    """Draw a Pose.

    head: Template in the shape of the face. size: pixels, of the picture. filled: longer side of the landmarks' box, of
    the picture's.
    """
    rotation = head_rotation(np.radians(_random_angles(generator, settings)))
    middle = head.vertices.mean(0)
    flat = (head.vertices[head.annotation.landmarks[:COUNT]] - middle) @ rotation[:2].T
    scale = filled * size / max(np.ptp(flat, axis=0).max(), 1e-6)
    room = max(0.5 - filled / 2, 0) + 0.06
    aside = generator.uniform(-1, 1, 2) * (settings.aside if filled > settings.filled[0] else room)
    translation = size * (0.5 + aside) - scale * (flat.min(0) + flat.max(0)) / 2
    height = float(np.ptp(head.vertices[:, 1]))
    return Pose(rotation, float(scale), translation, float(generator.uniform(0, settings.perspective)), middle, height)


def _random_angles(generator: np.random.Generator, settings: PoseSettings) -> list[float]:
    """Pitch, yaw and roll, degrees."""
    yaw = generator.normal(0, settings.yaw)
    if generator.random() < settings.turned:
        yaw = generator.uniform(-settings.farthest, settings.farthest)
    roll = generator.normal(0, settings.roll)
    if generator.random() < settings.rolled:
        roll = generator.uniform(-settings.roll_far, settings.roll_far)
    yaw = settings.around + np.clip(yaw, -settings.farthest, settings.farthest)
    return [generator.normal(0, settings.pitch), float(yaw), float(roll)]
