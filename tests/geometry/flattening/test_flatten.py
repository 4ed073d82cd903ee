import numpy as np
import pytest

from caricli.geometry.flattening.embed_disc import embed_disc
from caricli.geometry.flattening.flatten import Limits, Sheet, flatten
from caricli.geometry.flattening.triangle_stretch import triangle_stretch
from caricli.geometry.repair.fill_holes import fill_holes


def grid(columns, rows, holes=()):
    """Vertices of a flat sheet with a step of 0.1, and its triangles but those of the cells in ``holes``."""
    y, x = (a.ravel() for a in np.mgrid[: rows + 1, : columns + 1])
    corner = [r * (columns + 1) + c for r in range(rows) for c in range(columns) if (r, c) not in holes]
    corner = np.array(corner)
    up = corner + columns + 1
    faces = np.concatenate([np.stack([corner, corner + 1, up + 1], 1), np.stack([corner, up + 1, up], 1)])
    return 0.1 * np.stack([x - columns / 2, y, 0.0 * x], 1), faces


def sheet(vertices, faces, size=1.0):
    return Sheet(vertices, faces, np.broadcast_to(size, len(vertices)), np.ones(len(faces)))


def started(vertices, faces):
    return embed_disc(vertices, faces, fill_holes(vertices, faces)[2])


@pytest.fixture(scope="module")
def cap(ball):
    """Half of a sphere that has no symmetry."""
    vertices, faces = ball
    faces = faces[(vertices[faces][:, :, 2] > 0).all(1)]
    ids = np.unique(faces)
    return vertices[ids], np.searchsorted(ids, faces)


def test_a_bent_sheet_becomes_the_flat_one_that_it_was():
    flat, faces = grid(8, 6)
    bent = np.stack([np.sin(flat[:, 0]), flat[:, 1], 1 - np.cos(flat[:, 0])], 1)
    places = flatten(sheet(bent, faces), started(bent, faces))
    # A cylinder of chords: each strip is a little shorter than its arc, all edges are as long as on the surface.
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    long = [np.linalg.norm(np.diff(p[edges], axis=1)[:, 0], axis=1) for p in (bent, places)]
    np.testing.assert_allclose(long[1], long[0], rtol=0.02)


def test_sizes_are_kept_where_they_can_be(cap):
    vertices, faces = cap
    areas = {}
    for size in (1.0, 3.0):
        places = flatten(sheet(vertices, faces, size), size * started(vertices, faces))
        stretch = triangle_stretch(vertices, faces, places, faces)
        assert (stretch[:, 1] > 0).all()
        areas[size] = stretch.prod(1)
    np.testing.assert_allclose(areas[3.0], 9 * areas[1.0], rtol=0.02)
    # Where triangles are to be larger on one side, they are.
    slope = np.exp(0.8 * vertices[:, 0])
    stretch = triangle_stretch(vertices, faces, flatten(sheet(vertices, faces, slope), started(vertices, faces)), faces)
    middles = vertices[faces].mean(1)[:, 0]
    assert np.corrcoef(np.log(stretch.prod(1)), 1.6 * middles)[0, 1] > 0.9


def test_what_counts_more_is_kept_better(cap):
    vertices, faces = cap
    left = vertices[faces].mean(1)[:, 0] < 0
    errors = []
    for weight in (1.0, 50.0):
        given = Sheet(vertices, faces, np.ones(len(vertices)), np.where(left, weight, 1.0))
        stretch = triangle_stretch(vertices, faces, flatten(given, started(vertices, faces)), faces)
        errors.append(np.mean((stretch[left] - 1) ** 2))
    assert errors[1] < 0.7 * errors[0]


def test_triangles_count_by_their_areas():
    """A strip that has to be smaller on one side gives way there as much, in however many triangles it is divided."""
    widths = []
    for columns in (4, 16):
        steps = np.r_[np.linspace(-1, 0, 5)[:-1], np.linspace(0, 1, columns + 1)]
        x, y = (a.ravel() for a in np.meshgrid(steps, [0, 1.0]))
        count = columns + 5
        corner = np.arange(count - 1)
        faces = np.concatenate([np.stack([corner, corner + 1, corner + count + 1], 1),
                                np.stack([corner, corner + count + 1, corner + count], 1)])  # fmt: skip
        vertices = np.stack([x, y, 0 * x], 1)
        places = flatten(sheet(vertices, faces), vertices[:, :2] * [0.4, 1], Limits(np.array([[1.0, 0, 0.5]]), 10.0))
        widths.append(places[corner[-1] + 1, 0] - places[4, 0])
    np.testing.assert_allclose(*widths, rtol=0.03)


def test_triangles_may_have_shapes_of_their_own(cap):
    vertices, faces = cap
    given = Sheet(vertices, faces, np.ones(len(vertices)), np.ones(len(faces)), 3 * vertices[faces])
    places = flatten(given, 3 * started(vertices, faces))
    np.testing.assert_allclose(places, flatten(sheet(vertices, faces, 3.0), 3 * started(vertices, faces)), atol=1e-6)


def test_limits_hold_on_both_sides_and_nothing_turns_over():
    vertices, faces = grid(10, 4)
    lines = np.array([[1.0, 0, 0.4], [0, -1, 0.0], [np.sqrt(0.5), np.sqrt(0.5), 0.5]])
    start = vertices[:, :2] * [1, 1.2]
    places = flatten(sheet(vertices, faces), start, Limits(lines, 1e5))
    assert np.ptp(start[:, 0]) == 1.0 and np.abs(places[:, 0]).max() < 0.402
    assert places[:, 1].min() > -0.002 and (np.abs(places[:, 0]) + places[:, 1]).max() < 0.5 * np.sqrt(2) + 0.002
    assert (triangle_stretch(vertices, faces, places, faces)[:, 1] > 0).all()


def test_what_starts_turned_over_is_a_mistake():
    vertices, faces = grid(3, 3)
    with pytest.raises(AssertionError, match="without flipped triangles"):
        flatten(sheet(vertices, faces), vertices[:, :2] * [-1, 1])


def test_holes_are_closed_and_the_longest_border_is_left():
    vertices, faces = grid(7, 6, holes={(2, 2), (2, 3), (4, 5)})
    more, closed, loop = fill_holes(vertices, faces)
    assert len(more) == len(vertices) + 2 and len(closed) == len(faces) + 6 + 4
    assert set(loop) == {k for k, (x, y, _) in enumerate(vertices) if abs(x) > 0.34 or y in (0.0, vertices[:, 1].max())}
    np.testing.assert_allclose(triangle_stretch(more, closed, more[:, :2], closed), 1)
    assert fill_holes(*grid(3, 3))[1].shape == (18, 3)


def test_the_longest_border_is_that_of_the_greatest_length():
    """Around a hole edges may be short and many."""
    vertices, faces = grid(3, 3, holes={(1, 1)})
    hole = faces[:0]
    ring = np.array([5, 6, 10, 9])
    inner = vertices[ring].mean(0) + 0.2 * (np.repeat(vertices[ring], 5, 0) - vertices[ring].mean(0))
    angles = np.linspace(0, 2 * np.pi, 20, endpoint=False) - 3 * np.pi / 4
    inner[:, :2] = vertices[ring, :2].mean(0) + 0.02 * np.stack([np.cos(angles), np.sin(angles)], 1)
    ids = len(vertices) + np.arange(20)
    for k in range(20):
        own, after = ring[k // 5], ring[(k + 1) // 5 % 4]
        hole = np.vstack([hole, [[own, ids[(k + 1) % 20], ids[k]]]])
        if own != after:
            hole = np.vstack([hole, [[own, after, ids[(k + 1) % 20]]]])
    _, _, loop = fill_holes(np.vstack([vertices, inner]), np.vstack([faces, hole]))
    assert len(loop) == 12 and loop.max() < len(vertices)


def test_the_border_of_a_disc_keeps_the_shares_of_its_lengths():
    x = np.array([0, 0.1, 0.5, 0.6, 1.5])
    vertices, faces = grid(4, 2)
    vertices = np.stack([x[np.arange(15) % 5], vertices[:, 1] ** 2, 0 * vertices[:, 0]], 1)
    loop = fill_holes(vertices, faces)[2]
    places = embed_disc(vertices, faces, loop)
    first, second = (points[np.append(loop, loop[0])] for points in (vertices, places))
    lengths = np.linalg.norm(np.diff(first, axis=0), axis=1)
    angles = 2 * np.arcsin(np.linalg.norm(np.diff(second, axis=0), axis=1) / 2)
    np.testing.assert_allclose(angles, 2 * np.pi * lengths / lengths.sum(), atol=1e-9)


def test_a_disc_is_spread_without_folds_however_it_is_bent(cap):
    vertices, faces = cap
    bag = np.where(vertices[:, 2:] > 0.6, vertices * [0.1, 0.1, 1], vertices)
    _, _, loop = fill_holes(bag, faces)
    places = embed_disc(bag, faces, loop)
    np.testing.assert_allclose(np.linalg.norm(places[loop], axis=1), 1)
    assert (triangle_stretch(bag, faces, places, faces)[:, 1] > 0).all()
    inner = np.setdiff1d(np.arange(len(bag)), loop)
    assert np.linalg.norm(places[inner], axis=1).max() < 1


def test_stretch_is_that_of_the_map():
    vertices, faces = grid(2, 2)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    for change, expected in (([3, 2], [3, 2]), ([0.5, 4], [4, 0.5]), ([-3, 2], [3, -2])):
        stretch = triangle_stretch(5 + vertices @ turn, faces, vertices[:, :2] * change, faces)
        np.testing.assert_allclose(stretch, np.broadcast_to(expected, (8, 2)))
