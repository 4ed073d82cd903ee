import numpy as np
from scipy.spatial.distance import pdist

from caricli.geometry.flattening.turn_upright import turn_upright


def test_a_turned_plane_is_turned_back():
    generator = np.random.default_rng(1)
    flat = generator.normal(size=(40, 2))
    flat -= flat.mean(0)
    angle = 2.3
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    # Up in space is up in the plane where x and y of the points do not go along with each other.
    x, y = np.linalg.qr(flat)[0].T
    points = np.column_stack([x, y, generator.normal(size=40)])
    np.testing.assert_allclose(turn_upright(points[:, :2] @ turn.T + [4, 5], points), points[:, :2], atol=1e-12)


def test_nothing_becomes_larger_or_smaller():
    generator = np.random.default_rng(2)
    places = generator.normal(size=(12, 2))
    for size in (1e-3, 1.0, 50.0):
        upright = turn_upright(size * places, generator.normal(size=(12, 3)))
        np.testing.assert_allclose(pdist(upright), size * pdist(places))
        np.testing.assert_allclose(upright.mean(0), 0, atol=1e-12 * size)
