"""Eyeballs in pictures."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.pictures.light import Sky
from caricli.methods.pictures.pose import Pose
from caricli.render.sky import DIRECTIONS
from caricli.structures.parsing import Region

_CAP = 0.3  # cosine from the front: an eyeball shows no more of it
_GLINT = 0.16  # radius of the mirrored lamp, of the eyeball's
_PUPIL = 0.008
_WHITE = np.array([0.78, 0.74, 0.70])


@dataclass(frozen=True, eq=False)
class Eyes:
    """Somebody's eyes. balls: centres (3,) and radii, metres. iris: (3,) linear colour. reach: radians, of the iris."""

    balls: list[tuple[np.ndarray, float]]
    iris: np.ndarray
    reach: float


@dataclass(frozen=True, eq=False)
class Canvas:
    """A picture that is being drawn: colours (S, S, 3) linear light, region (S, S), depth (S, S) pixels."""

    colours: np.ndarray
    region: np.ndarray
    depth: np.ndarray


def draw_eyes(canvas: Canvas, eyes: Eyes, pose: Pose, sky: Sky, generator: np.random.Generator) -> None:
    """Draw eyeballs into a picture where nothing is before them, both looking the same way."""
    gaze = np.array([generator.normal(0, 0.18), generator.normal(0, 0.1), 1.0])
    gaze = pose.rotation @ (gaze / np.linalg.norm(gaze))
    pupil = eyes.reach * generator.uniform(0.3, 0.6)
    white = _WHITE * generator.uniform(0.7, 1.15)
    radiance = sky.radiance(DIRECTIONS)
    for ball in eyes.balls:
        window, normals, seen = _ball(canvas, ball, pose)
        away = np.arccos(np.clip(normals[seen] @ gaze, -1, 1))
        albedo = np.where((away < eyes.reach)[:, None], eyes.iris, white)
        albedo = np.where((away < pupil)[:, None], _PUPIL, albedo)
        received = 4 / len(DIRECTIONS) * np.maximum(normals[seen] @ DIRECTIONS.T, 0) @ radiance
        # The upper lid shades what is below it.
        shadow = np.clip(0.95 + 0.55 * normals[seen][:, 1:2], 0.35, 1)
        mirrored = (np.linalg.norm(normals[seen] - sky.half, axis=1) < _GLINT)[:, None]
        canvas.colours[window][seen] = np.where(mirrored, 0.95, albedo * received * shadow)
        canvas.region[window][seen] = Region.EYES


def _ball(
    canvas: Canvas, ball: tuple[np.ndarray, float], pose: Pose
) -> tuple[tuple[slice, slice], np.ndarray, np.ndarray]:
    """The window of the picture that a ball is in, its normals (H, W, 3) there, and where (H, W) it is seen."""
    centre, radius = ball
    x, y, z = pose.place(centre[None])[0]
    reach = radius * float(pose.size_at(z / pose.scale))
    window = _range(y, reach, len(canvas.depth)), _range(x, reach, len(canvas.depth))
    rows, columns = np.mgrid[window]
    across = (columns - x) / reach
    down = (rows - y) / reach
    inside = 1 - across**2 - down**2
    normals = np.stack([across, down, -np.sqrt(np.maximum(inside, 0))], -1)
    front = pose.rotation @ np.array([0.0, 0.0, 1.0])
    nearer = z + radius * pose.scale * normals[..., 2] < canvas.depth[window]
    return window, normals, (inside > 0) & nearer & (normals @ front > _CAP)


def _range(middle: float, reach: float, size: int) -> slice:
    low, high = (int(np.clip(value, 0, size)) for value in (np.floor(middle - reach), np.ceil(middle + reach) + 1))
    return slice(low, high)
