"""What a picture shows between lips, in the chart of the face."""

import numpy as np

from caricli.methods.dynamic.chart_pictures import ChartGrid, picture_to_chart
from caricli.structures import Face

_APART = (1.0, 3.0)
"""Pixels between the lips with which nothing and all of the picture counts: what is narrower would be smeared."""


def show_mouth(texture: np.ndarray, picture: np.ndarray, face: Face, grid: ChartGrid) -> np.ndarray:
    """Put what a picture shows between the lips into a texture of the chart, as far as they are apart there.

    Where they are not, nobody sees what the chart has between them: it gets one colour, that of the inner lips, lest a
    network learn what chance has left there.

    texture: (S, S, 3) uint8, as of ``texture_to_chart``, where between the lips their colours go over into each other.
    picture: (H, W, 3) uint8. face: Face with the camera that it is seen by. grid: ChartGrid of its mesh.
    Returns (S, S, 3) uint8. Raises InputError where the face has no camera or is of another mesh.
    """
    there = picture_to_chart(picture, face, grid)
    places = grid.bake(face.require_camera().project(face.vertices))
    inside = grid.mouth[..., None]
    high = np.where(inside, places, -np.inf).max(0)
    low = np.where(inside, places, np.inf).min(0)
    gaps = np.where(grid.mouth.any(0), np.linalg.norm(np.where(np.isfinite(high), high - low, 0), axis=1), 0)
    share = np.clip((gaps - _APART[0]) / (_APART[1] - _APART[0]), 0, 1)[None, :, None] * inside
    shut = np.where(inside, np.median(texture[grid.mouth], axis=0) if inside.any() else 0, texture)
    return np.round((1 - share) * shut + share * there).astype(np.uint8)
