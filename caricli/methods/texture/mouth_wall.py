"""The wall of the mouth, before which teeth stand."""

import numpy as np

from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.render.visibility.vertex_pixels import vertex_pixels
from caricli.structures import Camera, Material
from caricli.structures.materials import FINISHES, colour_share, toned
from caricli.template.template import Template

MOUTH = 0.5 * np.array(FINISHES[Material.GUMS].colour)
"""sRGB of the wall: as gums, in their shadow."""

_RINGS = 3  # of vertices, over which the colour of the lips goes over into it


def mouth_wall(head: Template) -> np.ndarray:
    """(V,) from 0 at the lips to 1 behind them, how far vertices are of the wall of the mouth."""
    _, mean = vertex_neighbours(head.faces, len(head.vertices))
    inside = head.mask("inner_mouth").astype(float)
    rings = []
    for _ in range(_RINGS):
        inside = (mean @ inside > 1 - 1e-9).astype(float)
        rings.append(inside)
    return np.mean(rings, axis=0)


def wall_colour(colours: np.ndarray) -> np.ndarray:
    """sRGB (3,) of the wall in a head of colours (N, 3): MOUTH, and grey where these are grey."""
    return toned(MOUTH, colour_share(colours))


def wall_pixels(head: Template, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """(H, W) bool, where a picture of a head shows the wall of its mouth. size: (W, H) of the picture, pixels."""
    return vertex_pixels(head, mouth_wall(head) > 0, camera, size)
