import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.visibility.rasterise import rasterise


def slow_raster(vertices, faces, width, height):
    """Signed-area test of every pixel against every triangle; the smaller depth wins."""
    face, depth = np.full((height, width), -1), np.full((height, width), np.inf)
    barycentric = np.zeros((height, width, 3))
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    for k, (a, b, c) in enumerate(vertices[faces]):
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
        v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
        weights = np.stack([u, v, 1 - u - v], -1)
        z = weights @ np.array([a[2], b[2], c[2]])
        nearer = (weights >= 0).all(-1) & (z < depth)
        face[nearer], depth[nearer], barycentric[nearer] = k, z[nearer], weights[nearer]
    return face, barycentric, depth


def test_agrees_with_a_test_of_every_pixel_against_every_triangle():
    rng = np.random.default_rng(3)
    vertices = rng.uniform([-5, -5, -3], [45, 35, 9], (90, 3))
    faces = np.arange(90).reshape(30, 3)
    raster = rasterise(vertices, faces, 40, 30)
    face, barycentric, depth = slow_raster(vertices, faces, 40, 30)
    assert raster.face.shape == (30, 40) and raster.face.dtype == np.int32
    assert raster.barycentric.shape == (30, 40, 3) and raster.depth.shape == (30, 40)
    same = raster.face == face
    assert same.mean() > 0.995 and (face >= 0).mean() > 0.5  # single and double precision part on borders only
    np.testing.assert_allclose(raster.barycentric[same], barycentric[same], atol=1e-3)
    np.testing.assert_allclose(raster.depth[same], depth[same], atol=1e-3)
    assert (np.isinf(raster.depth) == (raster.face < 0)).all()


def test_the_nearest_surface_wins_whatever_its_order_and_winding():
    square = np.array([[1.0, 1, 0], [8, 1, 0], [8, 8, 0], [1, 8, 0]])
    vertices = np.concatenate([square + [0, 0, 5], square + [0, 0, 2], square + [0, 0, 7]])
    faces = np.concatenate(
        [
            k * 4 + np.array(f)
            for k, f in enumerate([[[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 3, 2]], [[0, 1, 2], [0, 2, 3]]])
        ]
    )
    raster = rasterise(vertices, faces, 10, 10)
    assert set(np.unique(raster.face)) == {-1, 2, 3}
    assert np.allclose(raster.depth[raster.face >= 0], 2)


def test_the_centre_of_the_top_left_pixel_is_the_origin():
    triangle = np.array([[-0.4, -0.4, 0], [0.9, -0.4, 0], [-0.4, 0.9, 0]])
    raster = rasterise(triangle, [[0, 1, 2]], 3, 2)
    assert np.argwhere(raster.face >= 0).tolist() == [[0, 0]]
    np.testing.assert_allclose(raster.barycentric[0, 0] @ triangle, [0, 0, 0], atol=1e-6)


def test_inputs_are_not_changed_and_the_same_input_gives_the_same_bytes(sphere):
    vertices, faces = sphere[0] * 20 + 24, sphere[1]
    before = vertices.copy(), faces.copy()
    first, second = rasterise(vertices, faces, 48, 48), rasterise(vertices, faces, 48, 48)
    assert (vertices == before[0]).all() and (faces == before[1]).all()
    for name in ("face", "barycentric", "depth"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()


def test_no_triangles_and_triangles_without_area_draw_nothing():
    for faces in (np.zeros((0, 3), int), [[0, 0, 0]]):
        assert (rasterise(np.zeros((1, 3)), faces, 4, 4).face == -1).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e308])
def test_refuses_coordinates_that_are_not_finite(bad):
    with pytest.raises(InputError, match="finite"):
        rasterise([[0, 0, 0], [1, 0, 0], [0, bad, 0]], [[0, 1, 2]], 4, 4)


@pytest.mark.parametrize("faces", [[[0, 1, 3]], [[0, 1, -1]], [[0, 1]]])
def test_refuses_faces_that_point_nowhere(faces):
    with pytest.raises(InputError, match="faces"):
        rasterise(np.eye(3), faces, 4, 4)


def test_neighbours_leave_no_gap():
    """A sheet of slivers, their corners on centres of pixels and beside them, covers every pixel."""
    rng = np.random.default_rng(4)
    places = np.stack(np.meshgrid(np.arange(0, 33, 4.0), np.arange(0, 25, 0.5), indexing="ij"), -1)
    places[1:-1, 1:-1] += rng.uniform(-0.2, 0.2, places[1:-1, 1:-1].shape) * rng.integers(0, 2, (7, 48, 1))
    vertices = np.concatenate([places.reshape(-1, 2) - 0.5, np.zeros((places[..., 0].size, 1))], 1)
    ids = np.arange(places[..., 0].size).reshape(places.shape[:2])
    corners = [ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]]
    faces = np.concatenate([np.stack([corners[k] for k in t], -1).reshape(-1, 3) for t in ((0, 1, 2), (0, 2, 3))])
    raster = rasterise(vertices, faces, 32, 24)
    assert (raster.face >= 0).all()
    np.testing.assert_allclose(raster.barycentric.sum(-1), 1, atol=1e-6)
    np.testing.assert_allclose(
        np.einsum("hwk,hwkc->hwc", raster.barycentric, vertices[faces[raster.face]])[..., :2],
        np.stack(np.meshgrid(np.arange(32), np.arange(24)), -1),
        atol=1e-4,
    )
