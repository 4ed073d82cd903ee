import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from caricli.errors import InputError
from caricli.limits import MAX_CORNERS, MAX_VERTICES
from caricli.structures import Mesh
from caricli.structures.mesh import topology_id, triangle_fans

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
QUAD = np.array([[0, 1, 2, 3]], np.int32)
UVS = SQUARE[:, :2]


def square():
    return Mesh(SQUARE, QUAD, UVS, QUAD)


def test_polygons_become_fans_in_their_order():
    mesh = Mesh(np.eye(5)[:, :3] + np.arange(5)[:, None], [[0, 1, 2, -1, -1], [4, 3, 2, 1, 0], [0, 2, 4, 3, -1]])
    assert mesh.faces.tolist() == [[0, 1, 2], [4, 3, 2], [4, 2, 1], [4, 1, 0], [0, 2, 4], [0, 4, 3]]
    assert mesh.triangles_of_polygons.tolist() == [1, 3, 2] and mesh.faces.dtype == np.int32
    assert mesh.uvs is mesh.uv_polygons is None


@settings(deadline=None, derandomize=True)
@given(st.lists(st.permutations(range(9)).flatmap(lambda p: st.integers(3, 9).map(lambda n: p[:n])), min_size=1))
def test_fans_agree_with_a_slow_twin(rows):
    width = max(map(len, rows))
    polygons = np.array([row + [-1] * (width - len(row)) for row in rows])
    expected = [[row[0], row[k], row[k + 1]] for row in rows for k in range(1, len(row) - 1)]
    faces = triangle_fans(polygons)
    assert faces.tolist() == expected
    np.testing.assert_array_equal(Mesh(np.random.default_rng(0).random((9, 3)), polygons).faces, faces)


def test_triangles_of_polygons_tells_which_triangle_belongs_to_which_polygon():
    mesh = Mesh(np.arange(18.0).reshape(6, 3), [[0, 1, 2, -1], [5, 4, 3, 2], [1, 3, 5, -1]])
    owner = np.repeat(np.arange(3), mesh.triangles_of_polygons)
    assert len(owner) == len(mesh.faces)
    for polygon, triangle in zip(owner, mesh.faces, strict=True):
        assert set(triangle) <= set(mesh.polygons[polygon])


def test_uv_faces_go_with_the_faces():
    mesh = Mesh(SQUARE, QUAD, UVS + 2, [[3, 2, 1, 0]])
    assert mesh.uv_faces.tolist() == [[3, 2, 1], [3, 1, 0]] and mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_what_is_plain():
    faces = [[0, 1, 2], [0, 2, 3]]
    assert Mesh(SQUARE, faces).is_plain
    assert not Mesh(SQUARE, QUAD).is_plain
    assert not Mesh(SQUARE, faces, UVS, faces).is_plain


def test_types_of_the_arrays():
    mesh = Mesh(SQUARE.tolist(), QUAD.astype(np.int64).tolist(), UVS.astype(np.float32), QUAD.astype(np.uint8))
    assert (mesh.vertices.dtype, mesh.polygons.dtype) == (np.float64, np.int32)
    assert (mesh.uvs.dtype, mesh.uv_polygons.dtype) == (np.float64, np.int32)
    assert Mesh(SQUARE.astype(np.float32), QUAD).vertices.dtype == np.float32
    assert Mesh(SQUARE.astype(np.float16), QUAD).vertices.dtype == np.float64


def test_it_is_frozen():
    with pytest.raises(AttributeError):
        square().vertices = SQUARE


def test_height_is_the_vertical_extent():
    assert Mesh(3 * SQUARE - 7, QUAD).height == pytest.approx(3)


def test_topology_id_is_of_the_triangles_alone():
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    assert Mesh(SQUARE, QUAD).topology_id == hashlib.sha256(faces.tobytes()).hexdigest()
    assert square().topology_id == Mesh(2 * SQUARE, faces).topology_id == topology_id(np.asfortranarray(faces, int))
    assert topology_id(faces) != topology_id(faces[::-1])


def test_meshes_with_loose_vertices_are_of_a_topology_of_their_own():
    loose = Mesh(np.vstack([SQUARE, SQUARE]), QUAD)
    assert loose.topology_id != Mesh(SQUARE, QUAD).topology_id
    assert loose.topology_id == loose.with_vertices(2 * loose.vertices).topology_id


def test_quads_cut_along_the_other_diagonal_are_told_from_another_mesh():
    places = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]])
    quads = Mesh(places, [[0, 1, 4, 3], [1, 2, 5, 4]])
    assert Mesh(places, [[1, 4, 3], [0, 1, 3], [1, 2, 5], [1, 5, 4]]).cut_hint(quads)
    assert Mesh(places, quads.faces).cut_hint(quads)
    assert not Mesh(places, [[0, 1, 2], [0, 2, 5], [0, 5, 3], [3, 5, 4]]).cut_hint(quads)
    assert not Mesh(places, quads.faces[:3]).cut_hint(quads)
    assert "quads" in Mesh(places, quads.faces).cut_hint(quads)
    # Quads already, but from another corner, or in another order.
    assert "first corner" in Mesh(places, np.roll(quads.polygons, 1, axis=1)).cut_hint(quads)
    assert "in their order" in Mesh(places, quads.polygons[::-1]).cut_hint(quads)
    mixed = Mesh(places, [[0, 1, 4, 3], [1, 2, 5, -1], [1, 5, 4, -1]])
    assert Mesh(places, [[1, 4, 3], [0, 1, 3], [1, 2, 5], [1, 5, 4]]).cut_hint(mixed)
    assert not Mesh(places, [[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 5, 4]]).cut_hint(mixed)


def test_another_shape_shares_all_but_the_vertices():
    mesh = square()
    before = (mesh.faces, mesh.uv_faces, mesh.topology_id)
    other = mesh.with_vertices(2 * SQUARE)
    assert other.polygons is mesh.polygons and other.uvs is mesh.uvs and other.uv_polygons is mesh.uv_polygons
    assert (other.faces is before[0]) and (other.uv_faces is before[1]) and other.topology_id == before[2]
    np.testing.assert_array_equal(other.vertices, 2 * SQUARE)
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    assert mesh.with_vertices(SQUARE.astype(np.float32)).vertices.dtype == np.float32
    assert Mesh(SQUARE, QUAD).with_vertices(3 * SQUARE).faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_what_is_derived_of_a_shape_does_not_go_over_to_another():
    class Measured(Mesh):
        def __init__(self, *arrays):
            super().__init__(*arrays)
            vars(self)["area"] = 1.0

    other = Measured(SQUARE, QUAD).with_vertices(2 * SQUARE)
    assert type(other) is Measured and "area" not in vars(other)


@pytest.mark.parametrize(
    ("vertices", "words"),
    [
        (SQUARE[:3], r"vertices: expected \(4, 3\) as the mesh has, found \(3, 3\)"),
        (SQUARE[:, :2], "vertices: expected"),
        (SQUARE * np.nan, "vertices: expected finite coordinates"),
        (SQUARE * 1e9, "vertices: expected finite coordinates"),
    ],
)
def test_another_shape_is_checked_too(vertices, words):
    with pytest.raises(InputError, match=words):
        square().with_vertices(vertices)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"vertices": SQUARE[:, :2]}, r"vertices: expected \(V,3\) with V from 3 to 1000000, found \(4, 2\)"),
        ({"vertices": SQUARE[:2]}, r"vertices: expected \(V,3\)"),
        ({"vertices": SQUARE.ravel()}, r"vertices: expected \(V,3\)"),
        ({"vertices": np.zeros((MAX_VERTICES + 1, 3), np.float32)}, "vertices: expected"),
        ({"vertices": SQUARE * np.nan}, "vertices: expected finite coordinates of at most 1e.06, found others"),
        ({"vertices": SQUARE + np.inf}, "vertices: expected finite coordinates"),
        ({"vertices": SQUARE * 1e7}, "vertices: expected finite coordinates"),
        ({"polygons": QUAD + 1}, "^polygons: expected indices below 4, found 4"),
        ({"polygons": QUAD - 1}, "^polygons: expected rows of at least 3 indices followed by -1 only, found others"),
        ({"polygons": [[0, -1, 1, 2]]}, "^polygons: expected rows"),
        ({"polygons": [[0, 1, -1, -1]]}, "^polygons: expected rows"),
        ({"polygons": [[0, 1, 2, -2]]}, "^polygons: expected rows"),
        ({"polygons": QUAD % 3}, "^polygons: expected distinct corners, found one twice in row 0"),
        ({"polygons": [[0, 1, 2, 3], [0, 1, 2, 1]]}, "^polygons: expected distinct corners, found one twice in row 1"),
        ({"polygons": QUAD[:0]}, r"^polygons: expected \(P,N\)"),
        ({"polygons": QUAD.ravel()}, r"^polygons: expected \(P,N\)"),
        ({"polygons": QUAD[:, :2]}, r"^polygons: expected \(P,N\) with N from 3 to 64, found \(1, 2\)"),
        ({"polygons": np.zeros((1, 65), int)}, r"^polygons: expected \(P,N\)"),
        ({"polygons": np.zeros((MAX_CORNERS // 4 + 1, 4), np.int8)}, r"^polygons: expected \(P,N\)"),
        ({"polygons": QUAD.astype(np.int64) + 2**32}, "^polygons: expected indices below 4"),
        ({"polygons": [[0, 1, 2, -(2**63)]]}, "^polygons: expected rows"),
        ({"polygons": [[0, 1, -(2**63), 2]]}, "^polygons: expected rows"),
        ({"polygons": QUAD.astype(float)}, "^polygons: expected whole numbers, found float64"),
        ({"polygons": QUAD.astype(str)}, "^polygons: expected whole numbers, found <U"),
        ({"uvs": None}, "^uvs: expected them together with uv_polygons, found only one"),
        ({"uv_polygons": None}, "^uvs: expected them together with uv_polygons, found only one"),
        ({"uvs": SQUARE}, r"^uvs: expected \(T,2\), found \(4, 3\)"),
        ({"uvs": UVS * np.nan}, "^uvs: expected finite coordinates"),
        ({"uvs": UVS + 1e7}, "^uvs: expected finite coordinates"),
        ({"uv_polygons": QUAD[:, :3]}, "^uv_polygons: expected an index for every corner of polygons"),
        ({"uv_polygons": [[0, 1, 2, -1]]}, "^uv_polygons: expected an index for every corner of polygons"),
        ({"uv_polygons": QUAD + 1}, "^uv_polygons: expected indices below 4"),
        ({"uv_polygons": QUAD.astype(float)}, "^uv_polygons: expected whole numbers, found float64"),
    ],
)
def test_what_is_no_mesh_is_refused(changes, words):
    parts = {"vertices": SQUARE, "polygons": QUAD, "uvs": UVS, "uv_polygons": QUAD} | changes
    with pytest.raises(InputError, match=words) as caught:
        Mesh(**parts)
    assert "\n" not in str(caught.value)


def test_a_corner_of_a_picture_may_be_shared():
    assert Mesh(SQUARE, QUAD, UVS[:1], 0 * QUAD).uv_faces.tolist() == [[0, 0, 0], [0, 0, 0]]


def test_arrays_that_are_given_are_not_changed():
    given = (SQUARE.copy(), QUAD.copy(), UVS.copy(), QUAD.copy())
    Mesh(*given).with_vertices(2 * SQUARE)
    for array, expected in zip(given, (SQUARE, QUAD, UVS, QUAD), strict=True):
        np.testing.assert_array_equal(array, expected)
