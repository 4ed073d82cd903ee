import numpy as np
import pytest

from caricli.methods.inspect.check_mesh import check_mesh
from caricli.methods.inspect.size_hint import size_hint
from caricli.structures import Mesh


@pytest.fixture
def small(ball):
    """A ball of 0.2 m."""
    vertices, faces = ball
    return Mesh(0.1 * vertices, faces)


def test_a_whole_mesh_has_no_problems(small):
    check = check_mesh(small)
    assert (check.vertices, check.polygons, check.triangles, check.uvs) == (300, 596, 596, 0)
    assert (check.components, check.open_edges, check.flipped, check.hint) == (1, 0, None, None)
    assert check.height == pytest.approx(0.2, abs=0.01) and check.problems == []


def test_every_damage_is_counted(small):
    vertices = np.vstack([small.vertices, [[0.5, 0.5, 0.5]]])
    assert check_mesh(Mesh(vertices, small.faces)).problems == ["1 vertices in no triangle"]
    crowded = np.vstack([small.faces, [[*small.faces[0, :2], 200]]])
    check = check_mesh(Mesh(small.vertices, crowded))
    assert check.crowded == 1 and any("more than two triangles" in words for words in check.problems)
    flat = small.vertices.copy()
    flat[small.faces[0, 1]] = flat[small.faces[0, 0]]
    assert check_mesh(small.with_vertices(flat)).degenerate == 2
    turned = small.faces.copy()
    turned[5] = turned[5, ::-1]
    assert check_mesh(Mesh(small.vertices, turned)).misoriented == 3
    opened = check_mesh(Mesh(small.vertices, small.faces[1:]))
    assert opened.open_edges == 3 and opened.problems == []


def test_a_surface_inside_out_is_seen_closed_or_open(small):
    for faces in (small.faces, small.faces[(small.vertices[small.faces][..., 2] > 0).all(1)]):
        inwards = Mesh(small.vertices, faces[:, ::-1])
        assert "a surface inside out" in check_mesh(inwards).problems
        assert not check_mesh(Mesh(small.vertices, faces)).inside_out
    assert check_mesh(small.with_vertices(small.vertices * [-1, 1, 1])).problems == ["a surface inside out"]


def test_parts_are_counted(small):
    twice = Mesh(np.vstack([small.vertices, small.vertices + 1]), np.vstack([small.faces, small.faces + 300]))
    assert check_mesh(twice).components == 2


def test_triangles_are_turned_over_against_the_head_of_the_same_topology(small):
    dented = small.vertices.copy()
    dented[small.vertices[:, 2] > 0.08, 2] -= 0.1
    check = check_mesh(small.with_vertices(dented), small)
    assert check.flipped and check.problems == [f"{check.flipped} triangles turned over"]
    assert check_mesh(small, small).flipped == 0
    assert check_mesh(Mesh(small.vertices, small.faces[1:]), small).flipped is None


@pytest.mark.parametrize(
    ("scale", "words"), [(1, None), (100, "centimetres"), (1000, "millimetres"), (39.4, "inches"), (1e-3, "0.1 to 1 m")]
)
def test_the_size_hints_at_the_unit(small, scale, words):
    hint = check_mesh(small.with_vertices(small.vertices * scale)).hint
    assert hint == size_hint(small.height * scale)
    assert hint is None if words is None else words in hint


@pytest.mark.parametrize(
    ("height", "unit"),
    [(9.0, "inches"), (12, "inches"), (22, "centimetres"), (60, "centimetres"), (150, "millimetres")],
)
def test_of_several_units_the_one_of_a_usual_head_is_named(height, unit):
    assert f"as a head in {unit}" in size_hint(height)
