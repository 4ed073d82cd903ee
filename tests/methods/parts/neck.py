"""What closes a neck, whatever it is."""

import igl
import numpy as np

from caricli.geometry.join_meshes import join_meshes
from caricli.methods.parts.close_neck import neck_edge


def assert_closed(template, face, part):
    """The part begins at the edge of a neck, leaves no gap, and faces outwards as the skin does. face: (V, 3)."""
    edge = neck_edge(template)
    np.testing.assert_array_equal(part.mesh.vertices[: len(edge)], face[edge])
    whole = join_meshes([template.with_vertices(face), part.mesh])
    _, number = np.unique(whole.vertices, axis=0, return_inverse=True)
    faces = number.ravel()[whole.faces]
    assert len(igl.boundary_facets(faces)[0]) == 0
    # Every edge is gone along once each way.
    ways = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert len(np.unique(ways, axis=0)) == len(ways)
