"""Repair of triangles that a deformation has turned over."""

import numpy as np
import scipy.sparse as sp

from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.vertex_neighbours import vertex_neighbours

ROUNDS = 6
"""Solves: they turn back all but about one in a hundred flipped triangles of an exaggerated smile."""

RINGS = 3
"""Edges around a flipped triangle that its repair reaches."""

WIDEST = 4
"""Times ``RINGS``, reached round by round where there is a sound shape to go back to."""


def untangle(
    vertices: np.ndarray, gradients: DeformationGradients, rounds: int = ROUNDS, before: np.ndarray | None = None
) -> np.ndarray:
    """Smooth the deformation around flipped triangles until they turn back.

    In every round the features of the vertices within ``RINGS`` edges of a flipped triangle are blended with the mean
    of their neighbours' and the shape is solved again; the rest keeps its features, so its shape. Stops when nothing is
    flipped; a shape that gets no better is returned as it was.

    vertices: (V, 3). gradients: DeformationGradients of the template. rounds: at most. before: (V, 3), the shape that
    was edited: then only triangles count that are not flipped there, and it is the change of features that becomes the
    neighbours' mean, and less from round to round: kinks go, and the edit stays.
    Returns (V, 3).
    """
    accepted = np.zeros(len(gradients.faces), dtype=bool) if before is None else flipped_triangles(before, gradients)
    sound = None if before is None else gradients.features(before)
    flipped = flipped_triangles(vertices, gradients) & ~accepted
    best = vertices
    least = int(flipped.sum())
    if not least:
        return vertices
    neighbours, mean = vertex_neighbours(gradients.faces, gradients.count)
    near = np.zeros(gradients.count)
    for turn in range(rounds):
        rings = RINGS if sound is None else RINGS * min(1 + turn, WIDEST)
        around = _around(gradients.faces[flipped], neighbours, rings)
        features = gradients.features(vertices)
        if sound is None:
            near = np.maximum(near, around)
            target = mean @ (mean @ features)
        else:
            # Where nothing is flipped any more, the edit stays.
            near = around
            target = sound + (1 - turn / rounds) * (mean @ (mean @ (features - sound)))
        features += near[:, None] * (target - features)
        moved = gradients.vertices_like(features, vertices)
        still = near == 0
        vertices = moved + (vertices[still] - moved[still]).mean(0) if still.any() else moved
        flipped = flipped_triangles(vertices, gradients) & ~accepted
        if flipped.sum() < least:
            best = vertices
            least = int(flipped.sum())
        if not least:
            break
    return best


def _around(faces: np.ndarray, neighbours: sp.csr_matrix, rings: int) -> np.ndarray:
    """(V,) one at the corners of faces (F, 3), less from ring to ring around them, zero beyond."""
    touched = np.zeros(neighbours.shape[0])
    touched[faces.ravel()] = 1.0
    for ring in range(rings):
        touched = np.maximum(touched, (1 - (ring + 1) / (rings + 1)) * (neighbours @ touched > 0))
    return touched
