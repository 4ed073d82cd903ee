from types import SimpleNamespace

import numpy as np
import pytest

from caricli.geometry.subdivide import subdivide
from caricli.render.head_views import head_views
from caricli.render.views import render_views
from caricli.structures.mesh import triangle_fans

BARE = SimpleNamespace(curves={}, regions={})
VIEWS = ("front", "profile")


def finer(vertices, faces, levels):
    weights, quads = subdivide(faces, len(vertices), levels, 10**6)
    return weights @ vertices, triangle_fans(quads), weights


def test_without_a_finer_mesh_they_are_the_plain_views(lopsided):
    expected = render_views(*lopsided, VIEWS, 48)
    for fine in (None, finer(*lopsided, 0)):
        for found, picture in zip(head_views(*lopsided, BARE, VIEWS, 48, fine), expected, strict=True):
            np.testing.assert_array_equal(found, picture)


def test_a_finer_mesh_is_drawn_in_the_same_light(lopsided):
    coarse = head_views(*lopsided, BARE, VIEWS, 64)
    fine = head_views(*lopsided, BARE, VIEWS, 64, finer(*lopsided, 2))
    for a, b in zip(coarse, fine, strict=True):
        drawn = (a[..., 3] == 255) & (b[..., 3] == 255)
        assert drawn.mean() > 0.3 and (a[..., 3] != b[..., 3]).mean() < 0.1
        assert np.abs(a[drawn].astype(int) - b[drawn]).mean() < 6


@pytest.mark.parametrize("levels", [0, 1])
def test_eyeballs_are_placed_by_the_annotated_mesh(head_template, levels):
    shape, note = (head_template.vertices, head_template.faces), head_template.annotation
    fine = finer(head_template.vertices, head_template.polygons, levels)
    (with_eyes,) = head_views(*shape, note, ("front",), 96, fine)
    (without,) = head_views(*shape, BARE, ("front",), 96, fine)
    assert 20 < (np.abs(with_eyes.astype(int) - without).max(-1) > 40).sum() < 400
