import numpy as np
import pytest

from caricli.render.visibility.seen_vertices import seen_vertices


def test_the_near_side_is_seen_the_far_side_and_what_hides_behind_it_are_not(sphere):
    vertices, faces = sphere
    count = len(vertices)
    points = np.concatenate([20 * vertices, 8 * vertices + [0, 0, 60]]) + [31.5, 31.5, 0]
    both = np.concatenate([faces, faces + count])
    seen = seen_vertices(points, both, 64, 64)
    assert seen[:count][vertices[:, 2] < -0.2].all()
    assert not seen[:count][vertices[:, 2] > 0.4].any() and not seen[count:].any()
    assert not seen_vertices(points + [200, 0, 0], both, 64, 64).any()


@pytest.mark.parametrize("size", [16, 64, 256])
def test_triangles_that_share_no_vertices_are_seen_however_small_they_are(sphere, size):
    vertices = sphere[0][sphere[1]].reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)
    away = vertices[faces].mean(1)[:, 2] < -0.2
    seen = seen_vertices(size * (0.4 * vertices + 0.5), faces, size, size)
    assert seen[faces[away]].all() and not seen[vertices[:, 2] > 0.4].any()
