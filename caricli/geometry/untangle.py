"""Repair of triangles that a deformation has turned over."""

import numpy as np

from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.vertex_neighbours import vertex_neighbours

ROUNDS, RINGS, WIDEST = 6, 3, 4


def untangle(vertices, gradients, rounds=ROUNDS, before=None):
    """Smooth the deformation around flipped triangles until they turn back.

    In every round the features of the vertices within ``RINGS`` edges of a flipped triangle are blended with the mean
    of their neighbours' and the shape is solved again; the rest keeps its features, so its shape. Stops when nothing is
    flipped; a shape that gets no better is returned as it was.

    vertices: (V, 3). gradients: DeformationGradients of the template. before: (V, 3), the shape that was edited: then
    only triangles count that are not flipped there, and its features take the place of the neighbours' mean.
    Returns (V, 3).
    """
    accepted = np.zeros(len(gradients.faces), dtype=bool) if before is None else flipped_triangles(before, gradients)
    sound = None if before is None else gradients.features(before)
    flipped = flipped_triangles(vertices, gradients) & ~accepted
    best, best_count = vertices, int(flipped.sum())
    if not best_count:
        return vertices
    faces, count = gradients.faces, gradients.count
    neighbours, mean = vertex_neighbours(faces, count)
    near = np.zeros(count)
    for turn in range(rounds):
        # Where there is a sound shape to go back to, farther and farther around.
        rings = RINGS if sound is None else RINGS * min(1 + turn, WIDEST)
        touched = np.zeros(count)
        touched[faces[flipped].ravel()] = 1.0
        for ring in range(rings):
            touched = np.maximum(touched, (1 - (ring + 1) / (rings + 1)) * (neighbours @ touched > 0))
        near = np.maximum(near, touched)
        features = gradients.features(vertices)
        features += near[:, None] * ((mean @ (mean @ features) if sound is None else sound) - features)
        moved = gradients.vertices(features)
        still = near == 0
        vertices = moved + (vertices[still] - moved[still]).mean(0) if still.any() else moved
        flipped = flipped_triangles(vertices, gradients) & ~accepted
        if flipped.sum() < best_count:
            best, best_count = vertices, int(flipped.sum())
        if not best_count:
            break
    return best
