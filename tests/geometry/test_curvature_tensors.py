import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.geometry.curvature_tensors import curvature_tensors

TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()


def grid(height, slope):
    """A square of 41 x 41 vertices around the origin, 0.4 wide; its normals are those of the surface z = height."""
    x, y = (axis.ravel() for axis in np.meshgrid(*2 * [np.linspace(-0.2, 0.2, 41)]))
    corner = (np.arange(40)[:, None] * 41 + np.arange(40)).ravel()
    quads = np.stack([corner, corner + 1, corner + 42, corner + 41], axis=1)
    normals = np.stack([-slope(x, y)[0], -slope(x, y)[1], np.ones_like(x)], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.stack([x, y, height(x, y)], 1), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), normals


@pytest.mark.parametrize("radius", [0.1, 3.0])
def test_a_sphere_bends_alike_in_every_direction(ball, radius):
    vertices, faces = ball
    tensors = curvature_tensors(radius * vertices + 5, faces, vertices)
    across = np.eye(3) - vertices[:, :, None] * vertices[:, None, :]
    assert np.abs(radius * tensors - across).max() < 0.15
    np.testing.assert_array_equal(tensors, tensors.swapaxes(1, 2))


def test_a_saddle_bends_out_along_one_axis_and_in_along_the_other():
    """z = 2 x y - x^2, whose second derivatives at the origin are -2, 2 and 0."""
    mesh = grid(lambda x, y: 2 * x * y - x**2, lambda x, y: (2 * y - 2 * x, 2 * x))
    middle = curvature_tensors(*mesh)[41 * 20 + 20]
    np.testing.assert_allclose(middle, [[2, -2, 0], [-2, 0, 0], [0, 0, 0]], atol=0.01)
    vertices, faces, normals = mesh
    turned = curvature_tensors(vertices @ TURN.T - 3, faces, normals @ TURN.T)[41 * 20 + 20]
    np.testing.assert_allclose(turned, TURN @ middle @ TURN.T, atol=1e-9)


def test_triangles_without_an_area_say_nothing_and_neither_do_vertices_without_one(ball):
    vertices, faces = ball
    flat = np.array([[0, 0, 150], [7, 7, 7], [300, 300, 301]])
    more = np.vstack([vertices, vertices[:2]])
    tensors = curvature_tensors(more, np.vstack([faces, flat]), np.vstack([vertices, -vertices[:2]]))
    np.testing.assert_allclose(tensors[:300], curvature_tensors(vertices, faces, vertices), atol=1e-12)
    np.testing.assert_array_equal(tensors[300:], 0)
    np.testing.assert_array_equal(curvature_tensors(0 * vertices, faces, vertices), 0)
