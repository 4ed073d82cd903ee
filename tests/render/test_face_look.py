import numpy as np
import pytest

from caricli.geometry.mouth_light import mouth_light
from caricli.render.coat import mesh_coat
from caricli.render.face_look import combed_hair, face_look, head_eyeballs, head_look, plain_colours, with_parts
from caricli.render.pixels.srgb import to_linear
from caricli.render.shade import Look
from caricli.structures import Face, Material, Mesh, Part, Pictures
from caricli.structures.materials import FINISHES
from caricli.template.template import WholeHead


@pytest.fixture
def part(sphere):
    """Makes a small ball beside a head, a Part of a material."""

    def ball(material):
        vertices, faces = sphere
        mesh = Mesh(0.3 * vertices + [1.3, 0, 0], faces, np.full((len(vertices), 2), 0.5), faces)
        none = np.zeros((0, len(vertices), 3))
        return Part(material.name, mesh, np.full(len(faces), material, np.int32), "skull", (), none)

    return ball


def test_parts_have_the_colours_of_what_they_are_made_of_and_the_mesh_keeps_its_own(lopsided_mesh, part):
    count = len(lopsided_mesh.vertices)
    own = np.tile([10.0, 200, 30], (count, 1))
    for look, expected in ((Look(vertex_colours=own), own), (Look(colour=(1, 2, 3)), np.tile([1, 2, 3], (count, 1)))):
        joined, worn = with_parts(lopsided_mesh, look, [part(Material.CLOTH), part(Material.TEETH)])
        np.testing.assert_array_equal(worn.vertex_colours[:count], expected)
        cloth, teeth = np.split(worn.vertex_colours[count:], 2)
        assert (cloth == FINISHES[Material.CLOTH].colour).all() and len(joined.vertices) == count + len(cloth) * 2
        np.testing.assert_allclose(teeth.max(0), FINISHES[Material.TEETH].colour)


def test_parts_leave_the_pictures_and_materials_of_the_mesh(sphere, part):
    vertices, faces = sphere
    mesh = Mesh(vertices, faces, np.full((len(vertices), 2), 0.5), faces)
    pictures = Pictures(np.zeros((4, 4, 3), np.uint8))
    materials = np.where(np.arange(len(faces)) < 100, Material.BUST, Material.SKIN)
    _, worn = with_parts(mesh, Look(coat=mesh_coat(mesh, pictures, materials)), [part(Material.CLOTH)])
    np.testing.assert_array_equal(worn.coat.materials, [*materials, *np.full(len(faces), Material.CLOTH)])
    assert worn.coat.pictures is pictures
    _, bare = with_parts(mesh, Look(), [part(Material.CLOTH)])
    assert (bare.coat.materials[: len(faces)] == Material.SKIN).all() and not bare.coat.pictures
    look = Look()
    assert with_parts(mesh, look, ()) == (mesh, look)


def test_hair_is_combed_over_the_skin_and_nothing_else_is(lopsided_mesh, part):
    count = len(lopsided_mesh.vertices)
    _, worn = with_parts(lopsided_mesh, Look(), [part(Material.HAIR), part(Material.CLOTH)])
    assert worn.hair is not None and (worn.hair.at >= count).all()
    assert (worn.hair.below.indices < count).all()
    _, plain = with_parts(lopsided_mesh, Look(), [part(Material.CLOTH)])
    assert plain.hair is None
    assert combed_hair(lopsided_mesh, np.zeros(len(lopsided_mesh.faces), int)) is None


def test_a_head_is_drawn_with_eyeballs_unless_it_is_to_have_none(head_template):
    own = {name: getattr(head_template, name) for name in ("vertices", "polygons", "annotation")}
    assert len(head_eyeballs(head_template)) == len(head_eyeballs(WholeHead(**own))) == 2
    assert head_eyeballs(WholeHead(**own, eyes=False)) == []
    assert len(head_look(WholeHead(**own))[1].eyeballs) == 2


def test_a_whole_head_is_drawn_with_its_parts(lopsided_head, part):
    cloth = part(Material.CLOTH)
    head = WholeHead(
        lopsided_head.vertices, lopsided_head.polygons, annotation=lopsided_head.annotation, dressed=(cloth,)
    )
    mesh, look = head_look(head)
    assert len(mesh.faces) == len(head.faces) + len(cloth.mesh.faces) == len(look.coat.materials)
    assert head_look(lopsided_head)[0] is lopsided_head


def test_a_face_wears_what_it_is_made_of_and_gets_eyes_where_it_has_none(head_template):
    bare = Face(head_template)
    assert face_look(bare).vertex_colours is None and len(face_look(bare).eyeballs) == 2
    assert not len(face_look(bare, eyeballs=False).eyeballs)
    materials = np.full(len(head_template.polygons), Material.SKIN, np.int32)
    materials[:500] = Material.HAIR
    worn = face_look(Face(head_template, materials=materials))
    assert len(worn.eyeballs) == 2 and worn.hair is not None
    hair = np.unique(head_template.faces[worn.coat.materials == Material.HAIR])
    colours = {tuple(colour) for colour in worn.vertex_colours[hair]}
    assert tuple(map(float, FINISHES[Material.HAIR].colour)) in colours
    materials[-9:] = Material.EYE
    assert not len(face_look(Face(head_template, materials=materials)).eyeballs)


def test_teeth_are_darker_far_back_by_the_light_that_comes_there(sphere):
    vertices, faces = sphere
    materials = np.full(len(faces), Material.TEETH)
    colours = plain_colours(Mesh(vertices, faces), materials, Pictures())
    finish = np.array(FINISHES[Material.TEETH].colour, float)
    np.testing.assert_allclose(colours[vertices[:, 2].argmax()], finish, atol=0.01)
    share = to_linear(colours / 255) / to_linear(finish / 255)
    np.testing.assert_allclose(share, mouth_light(vertices, faces, materials), atol=1e-3)
    back = colours[vertices[:, 2].argmin()]
    assert back.max() < 0.5 * finish.max() and back[0] / back[2] > finish[0] / finish[2]
    skin = plain_colours(Mesh(vertices, faces), np.zeros(len(faces), int), Pictures())
    assert (skin == FINISHES[Material.SKIN].colour).all()


def test_teeth_beside_a_grey_skin_are_grey(sphere):
    vertices, faces = sphere
    grey = Pictures(np.full((4, 4, 3), 120, np.uint8))
    colours = plain_colours(Mesh(vertices, faces), np.full(len(faces), Material.GUMS), grey)
    np.testing.assert_allclose(colours, colours[:, :1].repeat(3, 1), atol=1e-3)
