import numpy as np
import pytest

from caricli.render.head_views import head_sky, head_views
from caricli.render.shade import Look
from caricli.render.views import render_views
from caricli.structures import Material, Mesh, Part
from caricli.template.fine_mesh import fine_mesh
from caricli.template.template import Template, WholeHead

VIEWS = ("front", "profile")


def test_without_a_finer_mesh_they_are_the_plain_views(lopsided_head):
    expected = render_views(lopsided_head, VIEWS, 48)
    for fine in (None, fine_mesh(lopsided_head, 0)):
        for found, picture in zip(head_views(lopsided_head, VIEWS, 48, fine), expected, strict=True):
            np.testing.assert_array_equal(found, picture)


def test_a_finer_mesh_is_drawn_in_the_same_light(lopsided_head):
    coarse = head_views(lopsided_head, VIEWS, 64)
    fine = head_views(lopsided_head, VIEWS, 64, fine_mesh(lopsided_head, 2))
    for a, b in zip(coarse, fine, strict=True):
        drawn = (a[..., 3] == 255) & (b[..., 3] == 255)
        assert drawn.mean() > 0.3 and (a[..., 3] != b[..., 3]).mean() < 0.1
        assert np.abs(a[drawn].astype(int) - b[drawn]).mean() < 6


@pytest.mark.parametrize("levels", [0, 1])
def test_eyeballs_are_placed_by_the_annotated_mesh(head_template, bare, levels):
    fine = fine_mesh(head_template, levels)
    blind = Template(head_template.vertices, head_template.polygons, annotation=bare)
    (with_eyes,) = head_views(head_template, ("front",), 96, fine)
    (without,) = head_views(blind, ("front",), 96, fine)
    assert 20 < (np.abs(with_eyes.astype(int) - without).max(-1) > 40).sum() < 400


@pytest.fixture
def dressed(lopsided_head, sphere):
    """The lopsided head with a ball of cloth on its left."""
    vertices, faces = sphere
    mesh = Mesh(0.4 * vertices + [1.2, 0, 0], faces, np.full((len(vertices), 2), 0.5), faces)
    materials = np.full(len(faces), Material.CLOTH, np.int32)
    ball = Part("ball", mesh, materials, "skull", (), np.zeros((0, len(vertices), 3)))
    given = lopsided_head
    return WholeHead(given.vertices, given.polygons, annotation=given.annotation, dressed=(ball,))


def test_parts_are_drawn_too_and_see_as_much_of_the_sky_beside_a_finer_mesh(dressed, lopsided_head):
    (picture,) = head_views(dressed, ("front",), 64)
    (bare,) = head_views(lopsided_head, ("front",), 64)
    blue = (picture[..., 2] > picture[..., 0].astype(int) + 8) & (picture[..., 3] == 255)
    assert blue.sum() > 60 and np.nonzero(blue)[1].mean() > 40
    assert not ((bare[..., 2] > bare[..., 0].astype(int) + 8) & (bare[..., 3] == 255)).any()
    (finer,) = head_views(dressed, ("front",), 64, fine_mesh(lopsided_head, 1))
    assert np.abs(finer[blue].astype(int) - picture[blue]).mean() < 4


def test_what_a_head_sees_of_the_sky_is_taken_as_it_is_given(dressed):
    sky = head_sky(dressed)
    assert len(sky) == len(dressed.vertices) + len(dressed.dressed[0].mesh.vertices)
    anew, given, dark = (
        head_views(dressed, ("front",), 48, look=Look(visibility=visibility))[0] for visibility in (None, sky, 0 * sky)
    )
    np.testing.assert_array_equal(anew, given)
    assert anew[..., :3].mean() > dark[..., :3].mean() + 5
