"""Where the head lies in its picture."""

import igl
import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from caricli.geometry.flattening.triangle_stretch import triangle_stretch
from caricli.render.visibility.uv_map import uv_map
from caricli.template.layout import bundled_layout

FACE = ("face", "nose")
SIZE = 1024


@pytest.fixture(scope="module")
def stretch(head_template):
    return triangle_stretch(
        head_template.vertices, head_template.faces, head_template.uvs, head_template.uv_faces
    )  # fmt: skip


@pytest.fixture(scope="module")
def areas(head_template, stretch):
    """Of the triangles in the picture."""
    return stretch.prod(1) * igl.doublearea(head_template.vertices, head_template.faces) / 2


@pytest.fixture(scope="module")
def islands(head_template):
    """(F,) int: the chart of every triangle."""
    corners = head_template.uv_faces
    count = len(head_template.uvs)
    edges = (corners.ravel(), np.roll(corners, 1, axis=1).ravel())
    return connected_components(coo_matrix((np.ones(corners.size), edges), (count, count)), False)[1][corners[:, 0]]


@pytest.fixture(scope="module")
def shown(head_template):
    """(SIZE, SIZE) int: the triangle under every texel."""
    return uv_map(head_template, SIZE)[0]


def test_no_triangle_is_turned_over_or_without_area(stretch):
    assert stretch[:, 1].min() > 0.1


def test_the_face_has_nearly_half_and_little_is_left(head_template, areas):
    face = head_template.mask(*FACE)[head_template.faces].all(1)
    assert areas[face].sum() >= 0.45
    assert 0.75 <= areas.sum() < 1


def test_nothing_lies_on_something_else(head_template, areas, shown):
    # Where no triangle is turned over and no borders cross, one chart can be on another only as a whole.
    edges = np.concatenate([head_template.uv_faces[:, [k, (k + 1) % 3]] for k in range(3)])
    edges, counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    first, last = np.moveaxis(head_template.uvs[edges[counts == 1]], 1, 0)
    assert len(first) > 300 and not crossing(first, last).any()
    assert (shown >= 0).mean() == pytest.approx(areas.sum(), abs=2e-4)


def crossing(first, last):
    """(E, E) bool: which of the lines from ``first`` to ``last`` cross, not counting ends that meet."""

    def side(a, b, c):
        return np.sign((b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0])

    a, b, c, d = first[:, None], last[:, None], first[None], last[None]
    return (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)


def test_lines_that_cross_are_seen():
    first, last = np.array([[[0, 0], [0, 1], [2, 0]], [[1, 1], [1, 0], [2, 1]]])
    assert crossing(first, last).sum() == 2


def test_every_part_has_its_chart(head_template, islands):
    assert len(np.unique(islands)) == 8
    for region in ("inner_mouth", "ear_left", "ear_right", "eye_socket_left", "eye_socket_right"):
        inside = head_template.mask(region)[head_template.faces].all(1)
        assert np.bincount(islands[inside]).max() > 0.85 * inside.sum(), region
    skin = head_template.mask("face", "scalp", "neck")[head_template.faces].all(1)
    assert len(np.unique(islands[skin])) == 1


def test_left_mirrors_right_to_the_last_bit(head_template):
    used = head_template.polygons >= 0
    pairs = np.unique(np.stack([head_template.polygons[used], head_template.uv_polygons[used]], 1), axis=0)
    places = {(vertex, *head_template.uvs[k]) for vertex, k in pairs.tolist()}
    mirror = head_template.annotation.mirror
    assert places == {(int(mirror[vertex]), 1 - u, v) for vertex, u, v in places}
    single = head_template.uvs.astype(np.float32)
    assert (single == head_template.uvs).all() and (1 - single == 1 - head_template.uvs).all()


def test_the_face_is_upright(head_template):
    used = head_template.polygons >= 0
    uv_of = np.zeros(len(head_template.vertices), int)
    uv_of[head_template.polygons[used]] = head_template.uv_polygons[used]
    marks = head_template.uvs[uv_of[head_template.annotation.landmarks[:68]]]
    assert (np.diff(marks[[8, 57, 33, 27], 1]) > 0.02).all()  # chin, lower lip, nose, its bridge
    np.testing.assert_array_equal(marks[[8, 27, 33], 0], 0.5)
    assert marks[45, 0] > 0.6 and marks[36, 0] < 0.4  # the subject's left eye is on the right, as one sees her


def test_mip_maps_do_not_mix_charts(islands, shown):
    # Three levels of the pyramid until two charts meet in one texel.
    chart = np.where(shown >= 0, islands[shown], -1)
    for number in np.unique(islands):
        others = (chart >= 0) & (chart != number)
        away = distance_transform_edt(~(chart == number))[others].min()
        assert away >= 8, number
    rows, columns = np.nonzero(chart >= 0)
    assert min(rows.min(), columns.min()) >= 4 and max(rows.max(), columns.max()) < SIZE - 4


def test_angles_and_sizes_of_the_face_are_kept(head_template, stretch, areas):
    face = head_template.mask(*FACE)[head_template.faces].all(1)
    surface = areas / stretch.prod(1)
    error = stretch[:, 0] / stretch[:, 1]
    assert np.average(error[face], weights=surface[face]) < 1.3
    logarithm = np.log(stretch.prod(1)[face])
    mean = np.average(logarithm, weights=surface[face])
    assert np.sqrt(np.average((logarithm - mean) ** 2, weights=surface[face])) < 0.25
    assert np.average(error, weights=surface) < 2.5


def test_seams_are_where_nobody_looks(head_template):
    used = head_template.polygons >= 0
    pairs = np.unique(np.stack([head_template.polygons[used], head_template.uv_polygons[used]], 1), axis=0)
    twice = np.flatnonzero(np.bincount(pairs[:, 0]) > 1)
    hidden = ("ear_left", "ear_right", "inner_mouth", "eye_socket_left", "eye_socket_right", "nostril_left")
    rest = twice[~head_template.mask(*hidden, "nostril_right")[twice]]
    # What remains is the cut along the back of the head and over the crown.
    np.testing.assert_array_equal(head_template.annotation.mirror[rest], rest)
    assert head_template.mask("scalp", "neck")[rest].all()


def test_the_mesh_itself_is_what_it_was(head_template):
    assert head_template.topology_id == "3d308289bbf619a6eb018f9e02f815903c4a4f8c63daafc2165564ac678c7a3f"
    assert bundled_layout()["uv_polygons"].shape == head_template.polygons.shape
