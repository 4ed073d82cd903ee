import numpy as np
import pytest

from caricli.render.head_views import head_views
from caricli.render.views import render_views
from caricli.template.fine_mesh import fine_mesh
from caricli.template.template import Template

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
