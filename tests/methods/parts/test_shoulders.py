import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.parts.close_neck import neck_edge
from caricli.methods.parts.face_parts import face_parts
from caricli.methods.parts.shoulders import THICKNESS, add_shoulders, open_head_shoulders
from caricli.methods.parts.whole_head import choose_head, whole_face
from caricli.structures import Face, HeadChoice, Material, Mesh, Rig
from tests.methods.parts.neck import assert_closed


@pytest.fixture(scope="module", params=[0, 1])
def face(head, head_template, request):
    """A usual head, and one of another size and pose whose neck is anything but even."""
    vertices = head.evaluate(gender=0.2, age=0.8)
    if request.param:
        edge = neck_edge(head_template)
        vertices = 3 * vertices + [0.1, 0.2, 0.3]
        vertices[edge] += 0.02 * np.random.default_rng(0).normal(size=(len(edge), 3))
    return vertices


def test_there_is_no_gap(head_template, face):
    assert_closed(head_template, face, add_shoulders(head_template, face))


def test_shoulders_keep_their_shape_and_stand_upright(head_template, face):
    rest = open_head_shoulders().mesh.vertices
    places = add_shoulders(head_template, face).mesh.vertices
    below = rest[:, 1] < -0.1
    scale = np.ptp(places[below], axis=0) / np.ptp(rest[below], axis=0)
    np.testing.assert_allclose(scale, scale[0], rtol=1e-6)
    np.testing.assert_allclose(
        places[below] - places[below].mean(0), scale * (rest[below] - rest[below].mean(0)), atol=1e-9
    )


def test_under_the_usual_head_it_is_the_bodys_own(head_template):
    bust = add_shoulders(head_template, head_template.vertices)
    np.testing.assert_allclose(bust.mesh.vertices, open_head_shoulders().mesh.vertices, atol=1e-9)
    assert set(bust.materials) == {Material.BUST, Material.CLOTH} and bust.hangs_on == "neck"
    # Its picture goes around as that of the neck does: once, beginning at the same vertex.
    rim = len(neck_edge(head_template))
    corners = zip(bust.mesh.polygons.ravel(), bust.mesh.uv_polygons.ravel(), strict=True)
    at = {int(vertex): bust.mesh.uvs[place] for vertex, place in corners}
    np.testing.assert_allclose([at[k] for k in range(1, rim)], [(k / rim, 1) for k in range(1, rim)], atol=1e-6)
    assert bust.mesh.uvs.min() >= 0 and bust.mesh.uvs.max() <= 1


def test_it_keeps_still_but_at_its_edge(head_template, face):
    edge = neck_edge(head_template)
    deltas = np.zeros((2, *face.shape))
    deltas[0, edge] = [0.001, -0.002, 0.003]
    bust = add_shoulders(head_template, face, ("moved", "still"), deltas)
    np.testing.assert_array_equal(bust.deltas[0, : len(edge)], deltas[0, edge])
    assert not bust.deltas[1].any()
    low = open_head_shoulders().mesh.vertices[:, 1] < -0.1
    assert low.sum() > 100 and np.abs(bust.deltas[0, low]).max() < 1e-12


def test_it_takes_the_place_of_the_cap(head_template, face):
    shown = Face(Mesh(face, head_template.polygons))
    assert [part.name for part in face_parts(shown, head_template, HeadChoice(("skin",), shoulders=True))] == ["bust"]
    names = [part.name for part in face_parts(shown, head_template, HeadChoice(shoulders=True))]
    assert "bust" in names and "neck" not in names


def test_another_topology_has_none(head_template, face):
    box = Face(Mesh(face[:4], np.array([[0, 1, 2, 3]])))
    with pytest.raises(InputError, match="bundled head's topology"):
        whole_face(box, HeadChoice(shoulders=True))


def test_a_head_that_has_its_parts_changes_its_cap_for_them(head_template, face):
    shown = Face(Mesh(face, head_template.polygons))
    whole = whole_face(whole_face(shown), HeadChoice(("skin", "teeth", "bust"), shoulders=True))
    assert {*whole.materials} == {*map(int, (0, Material.TEETH, Material.GUMS, Material.BUST, Material.CLOTH))}
    shoulders = add_shoulders(head_template, whole.vertices[:4200].astype(float))
    np.testing.assert_allclose(whole.vertices[-len(shoulders.mesh.vertices) :], shoulders.mesh.vertices, atol=1e-6)
    again = whole_face(whole, HeadChoice(("skin", "teeth", "bust"), shoulders=True))
    np.testing.assert_array_equal(again.vertices, whole.vertices)
    rig = Rig((), head_template.with_vertices(face.astype(np.float32)), np.zeros((0, *face.shape), np.float32))
    assert {*choose_head(rig, HeadChoice(shoulders=True)).materials} == {0, Material.BUST, Material.CLOTH}
    with pytest.raises(InputError, match="has its parts already"):
        whole_face(whole, HeadChoice(teeth="cartoon"))


def test_the_shirt_begins_at_a_loop_around_the_neck_and_stands_off_it(head_template):
    bust = add_shoulders(head_template, head_template.vertices)
    polygons = bust.mesh.polygons
    skin, cloth = (np.unique(polygons[bust.materials == m]) for m in (Material.BUST, Material.CLOTH))
    rim = len(neck_edge(head_template))
    border = np.intersect1d(skin, cloth[cloth >= 0])
    assert set(range(rim)) <= set(skin) and len(border) == rim
    # The shirt's own edge is as far from the skin below it as the shirt is thick.
    apart = np.linalg.norm(bust.mesh.vertices[border] - bust.mesh.vertices[-rim:], axis=1)
    np.testing.assert_allclose(apart, THICKNESS, rtol=1e-6)
