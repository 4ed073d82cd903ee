"""What tells where a part of a head is: points in it, and the skin around it."""

from dataclasses import dataclass

import numpy as np

from caricli.structures import Part
from caricli.template.template import Template

_FEWEST = 12
"""Vertices of a region that can tell where a part is."""

_MOST = 500
"""Vertices of the skin that are asked."""

_POINTS = 80
"""Of a part, that are asked for."""


@dataclass(frozen=True, eq=False)
class Frames:
    """Points in a part, and how heads differ there.

    points: (Q, 3) metres, in the template. examples: displacements (n, V, 3) of the skin and (n, Q, 3) of the points
    from the template to other heads; n may be 0.
    """

    points: np.ndarray
    examples: tuple[np.ndarray, np.ndarray]


def plain_frames(part: Part) -> Frames:
    """Frames of a part of which nothing but its place is known: points spread over it, however it is numbered."""
    vertices = np.asarray(part.mesh.vertices, float)
    vertices = vertices[np.lexsort(vertices.T)]
    points = vertices[np.linspace(0, len(vertices) - 1, min(_POINTS, len(vertices))).astype(int)]
    return Frames(points, (np.zeros((0, 0, 3)), np.zeros((0, len(points), 3))))


def surroundings(template: Template, part: Part) -> np.ndarray:
    """Vertices of the skin that say where a part is: the wall of the mouth, or else what it hangs on."""
    regions = template.annotation.regions
    ids = regions.get("inner_mouth", np.zeros(0, int))
    if len(ids) < _FEWEST:
        ids = regions.get(part.hangs_on, np.zeros(0, int))
    if len(ids) < _FEWEST:
        distance = np.linalg.norm(template.vertices - part.mesh.vertices.mean(0), axis=1)
        ids = np.argsort(distance, kind="stable")
    return ids[:: -(-len(ids) // _MOST)]
