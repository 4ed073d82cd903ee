import igl
import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.subdivide import subdivide
from caricli.geometry.triangle_normals import triangle_normals
from caricli.structures.mesh import triangle_fans

LIMIT = 10**6
# A house seen from its side: a pentagon, a quad and a triangle in the plane, and a quad and a triangle that leave it.
POINTS = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 0], [4, 0, 0], [4, 1, 0], [3, 2, 0], [0, 0, 3]])
POLYGONS = np.array([[0, 1, 2, 3, 4], [1, 5, 6, 2, -1], [2, 6, 7, -1, -1], [3, 2, 7, -1, -1], [0, 4, 8, -1, -1]])
# UVs of the same corners with seams: the pentagon and the last triangle stand alone, one corner is everywhere.
UV_POLYGONS = np.array([[0, 1, 2, 3, 4], [5, 6, 7, 8, -1], [8, 7, 9, -1, -1], [10, 8, 9, -1, -1], [0, 11, 11, -1, -1]])
UVS = np.random.default_rng(0).uniform(size=(12, 2))


def edges_of(polygons):
    pairs = [(row[k], row[(k + 1) % len(row)]) for row in rows_of(polygons) for k in range(len(row))]
    return {tuple(sorted(pair)) for pair in pairs}


def rows_of(polygons):
    return [[int(k) for k in row if k >= 0] for row in polygons]


def slow_level(points, polygons):
    """One level by dictionaries: points and quads."""
    points, middles, quads = list(points), {}, []

    def middle(ids):
        key = tuple(sorted(ids))
        if key not in middles:
            middles[key] = np.mean([points[k] for k in ids], axis=0)
        return middles[key]

    for row in rows_of(polygons):
        for k in range(len(row)):
            corner, after, before = row[k], row[(k + 1) % len(row)], row[k - 1]
            quads.append([points[corner], middle((corner, after)), middle(row), middle((before, corner))])
    return np.array(quads)


def test_level_0_changes_nothing():
    weights, polygons = subdivide(POLYGONS, len(POINTS), 0, LIMIT)
    assert np.array_equal(polygons, POLYGONS) and np.array_equal(weights.toarray(), np.eye(len(POINTS)))


def test_one_level_agrees_with_dictionaries():
    before = POLYGONS.copy()
    weights, quads = subdivide(POLYGONS, len(POINTS), 1, LIMIT)
    assert np.allclose((weights @ POINTS)[quads], slow_level(POINTS.astype(float), POLYGONS), atol=1e-15)
    assert np.array_equal(POLYGONS, before) and quads.dtype == np.int32


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_levels_are_repeated_single_levels(levels):
    weights, quads = subdivide(POLYGONS, len(POINTS), levels, LIMIT)
    points, polygons = POINTS.astype(float), POLYGONS
    for _ in range(levels):
        step, polygons = subdivide(polygons, len(points), 1, LIMIT)
        points = step @ points
    assert np.array_equal(quads, polygons) and np.allclose(weights @ POINTS, points, atol=1e-14)


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_counts_are_those_of_points_edges_and_polygons(ball, levels):
    for polygons, count in ((POLYGONS, len(POINTS)), (ball[1], len(ball[0]))):
        weights, quads = subdivide(polygons, count, levels, LIMIT)
        coarse, before = subdivide(polygons, count, levels - 1, LIMIT)
        assert weights.shape[0] == coarse.shape[0] + len(edges_of(before)) + len(before)
        assert len(quads) == sum(len(row) for row in rows_of(before))
        # Euler's characteristic stays, and no point is left over.
        characteristic = count - len(edges_of(polygons)) + len(polygons)
        assert weights.shape[0] - len(edges_of(quads)) + len(quads) == characteristic
        assert np.array_equal(np.unique(quads), np.arange(weights.shape[0]))


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_the_given_points_come_first_exactly_and_weights_are_means(levels):
    weights, _ = subdivide(POLYGONS, len(POINTS), levels, LIMIT)
    assert np.array_equal(weights[: len(POINTS)].toarray(), np.eye(len(POINTS)))
    assert (weights.data > 0).all() and np.abs(weights.sum(1) - 1).max() < 1e-14


@pytest.mark.parametrize("levels", [1, 3])
def test_fine_points_lie_on_the_coarse_surface_and_cover_it(ball, levels):
    vertices, faces = ball
    weights, quads = subdivide(faces, len(vertices), levels, LIMIT)
    fine, fine_faces = weights @ vertices, triangle_fans(quads)
    assert igl.point_mesh_squared_distance(fine, vertices, faces)[0].max() < 1e-28
    assert igl.doublearea(fine, fine_faces).sum() == pytest.approx(igl.doublearea(vertices, faces).sum(), rel=1e-12)
    # As many fine triangles stand in a row for each coarse one, and none of them is turned.
    owners = np.repeat(np.arange(len(faces)), len(fine_faces) // len(faces))
    assert ((triangle_normals(fine, fine_faces) * triangle_normals(vertices, faces)[owners]).sum(1) > 0).all()


def test_a_quad_becomes_a_lattice_of_its_bilinear_patch():
    corners = np.array([[0, 0, 0], [1, 0, 1], [1, 1, 0], [0, 1, 1.0]])
    weights, quads = subdivide([[0, 1, 2, 3]], 4, 3, LIMIT)
    x, y, z = (weights @ corners).T
    assert np.array_equal(np.unique(np.stack([x, y], 1) * 8, axis=0), np.argwhere(np.ones((9, 9))))
    assert np.allclose(z, x + y - 2 * x * y, atol=1e-15)
    assert quads.shape == (64, 4)


@pytest.mark.parametrize("levels", [1, 2])
def test_uvs_with_other_seams_fit_corner_by_corner(levels):
    weights, quads = subdivide(POLYGONS, len(POINTS), levels, LIMIT)
    uv_weights, uv_quads = subdivide(UV_POLYGONS, len(UVS), levels, LIMIT)
    assert uv_quads.shape == quads.shape
    # Every corner of a polygon on its own: the same weights reach points and UVs.
    loose = np.where(POLYGONS >= 0, np.cumsum(POLYGONS.ravel() >= 0).reshape(POLYGONS.shape) - 1, -1)
    used = POLYGONS >= 0
    loose_weights, loose_quads = subdivide(loose, used.sum(), levels, LIMIT)
    for values, table, found in (
        (POINTS, POLYGONS, (weights @ POINTS)[quads]),
        (UVS, UV_POLYGONS, (uv_weights @ UVS)[uv_quads]),
    ):
        assert np.allclose((loose_weights @ values[table[used]])[loose_quads], found, atol=1e-14)


def test_the_head_keeps_its_quads_and_seams(head):
    weights, quads = subdivide(head.polygons, 4200, 3, LIMIT)
    _, uv_quads = subdivide(head.uv_polygons, len(head.uvs), 3, LIMIT)
    assert weights.shape == (267_561, 4200) and quads.shape == uv_quads.shape == (4178 * 64, 4)
    assert np.array_equal(weights[:4200].indices, np.arange(4200)) and (weights[:4200].data == 1).all()


@pytest.mark.parametrize("levels", [1, 2, 4])
def test_too_many_points_are_refused_before_they_are_made(levels):
    made = subdivide(POLYGONS, len(POINTS), levels, LIMIT)[0].shape[0]
    subdivide(POLYGONS, len(POINTS), levels, made)
    with pytest.raises(InputError, match=f"memory cap: expected at most {made - 1} points, found {made}"):
        subdivide(POLYGONS, len(POINTS), levels, made - 1)
    with pytest.raises(InputError, match="memory cap"):
        subdivide(POLYGONS, len(POINTS), 40, LIMIT)
