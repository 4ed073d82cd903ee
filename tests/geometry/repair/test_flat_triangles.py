import numpy as np

from caricli.geometry.repair.flat_triangles import flat_triangles

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [0, 0, 1]], float)
FACES = np.array([[0, 1, 2], [0, 1, 3], [0, 2, 4]])


def test_only_what_has_no_area_is_flat():
    assert flat_triangles(VERTICES, FACES).tolist() == [False, True, False]
    assert flat_triangles(1e-5 * VERTICES - 3, FACES).tolist() == [False, True, False]
    assert flat_triangles(1e-8 * VERTICES, FACES).tolist() == [False, True, False]
    assert flat_triangles(0 * VERTICES, FACES).all()
