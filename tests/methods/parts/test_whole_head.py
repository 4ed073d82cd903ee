import numpy as np
import pytest

from caricli.methods.parts.whole_head import whole_face, whole_head
from caricli.structures import Face, Hair, HeadChoice, Material, Mesh, Pictures
from caricli.structures.head_choice import BARE

TRIANGLE = np.array([[0, 1, 2]], np.int32)


@pytest.fixture(scope="module")
def haired(head_template):
    """A face with a tuft of hair."""
    roots = np.repeat(head_template.faces[:1], 3, axis=0)
    shell = Mesh(head_template.vertices[roots[0]] + [0, 0.01, 0], TRIANGLE, np.zeros((1, 2)), 0 * TRIANGLE)
    pictures = Pictures(np.zeros((4, 4, 3), np.uint8), hair=np.zeros((4, 4, 3), np.uint8))
    return Face(head_template, pictures=pictures, hair=Hair(shell, roots, np.eye(3)))


def test_a_face_becomes_a_whole_head(haired, head_template):
    whole = whole_face(haired)
    assert set(whole.materials) == {*Material} - {Material.EYE, Material.CLOTH} and whole.hair is None
    np.testing.assert_allclose(whole.vertices[:4200], haired.vertices, atol=1e-7)
    np.testing.assert_allclose(whole.vertices[-3:], haired.hair.shell.vertices, atol=1e-7)
    assert whole.pictures.same(haired.pictures)
    template = whole_head(haired, head_template)
    assert [part.name for part in template.dressed] == [
        "teeth_upper",
        "teeth_lower",
        "tongue",
        "lashes",
        "neck",
        "hair",
    ]
    np.testing.assert_array_equal(template.vertices, haired.vertices)
    assert template.with_vertices(2 * haired.vertices).dressed == ()


@pytest.mark.parametrize("chosen, left", [(("skin",), {0}), (("skin", "hair"), {0, 6}), (("skin", "teeth"), {0, 2, 3})])
def test_some_of_it(haired, chosen, left):
    choice = HeadChoice(chosen)
    bare = whole_face(haired, choice)
    assert {*(bare.materials if bare.materials is not None else [0])} == left
    # What has parts already loses those that are not chosen.
    again = whole_face(whole_face(haired), choice)
    np.testing.assert_array_equal(again.vertices, np.float32(bare.vertices))
    np.testing.assert_array_equal(again.faces, bare.faces)


def test_a_skin_alone_gets_the_parts_that_it_was_left_without(head_template):
    choice = HeadChoice(("skin", "teeth"))
    skin = whole_face(whole_face(Face(head_template)), BARE)
    again = whole_face(skin, choice)
    np.testing.assert_array_equal(again.materials, whole_face(Face(head_template), choice).materials)
    assert Material.TEETH in again.materials


def test_another_topology_has_only_its_hair(ball):
    vertices, faces = ball
    shell = Mesh(2 * vertices[:3], TRIANGLE, np.zeros((1, 2)), 0 * TRIANGLE)
    face = Face(Mesh(*ball), hair=Hair(shell, np.zeros((3, 3), np.int32), np.full((3, 3), 1 / 3)))
    assert {*whole_face(face).materials} == {Material.SKIN, Material.HAIR}
