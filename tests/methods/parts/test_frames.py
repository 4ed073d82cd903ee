from dataclasses import replace

import numpy as np

from caricli.methods.parts.frames import plain_frames
from caricli.template.head import load_head
from caricli.template.head_parts import head_parts


def test_points_of_a_part_are_the_same_however_its_vertices_are_numbered():
    part = head_parts(load_head())[0]
    order = np.random.default_rng(0).permutation(len(part.mesh.vertices))
    renumbered = replace(part.mesh, vertices=part.mesh.vertices[order])
    other = replace(part, mesh=renumbered, deltas=part.deltas[:, order])
    points = plain_frames(part).points
    np.testing.assert_array_equal(plain_frames(other).points, points)
    assert (np.ptp(points, axis=0) > 0.8 * np.ptp(part.mesh.vertices, axis=0)).all()
