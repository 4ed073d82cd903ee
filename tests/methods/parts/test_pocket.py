"""Tests of the inside of a mouth."""

from dataclasses import replace

import igl
import numpy as np
import pytest

from caricli.methods.parts.pocket import Mouth, Pocket
from caricli.template.head import load_head

DEPTH = 5e-4
"""Metres: so far in a lip, or before it, points are."""

APART = -1e-3
"""Metres that points are to keep from the wall: none of these is so deep in it."""


@pytest.fixture(scope="module")
def opened():
    """A mouth half open, and the middle of the rim of its upper lip: points and normals (N, 3)."""
    head = load_head()
    template = head.template()
    skin = template.vertices + 0.5 * head.actions[head.action_names.index("jawOpen")].astype(float)
    pocket = Pocket(template, template.annotation.regions["inner_mouth"])
    rim = template.annotation.curves["mouth_inner_upper"][9:-9]
    normals = igl.per_vertex_normals(skin, template.faces.astype(np.int64))
    return Mouth(pocket, skin[pocket.lips.ids]), skin[rim], normals[rim]


def test_what_is_in_the_rim_of_a_lip_goes_out_of_it(opened):
    mouth, rim, normals = opened
    points = rim - DEPTH * normals
    pushes = mouth.pushes(points, APART)
    lengths = np.linalg.norm(pushes, axis=1)
    assert (lengths > 0).all()
    assert (lengths <= DEPTH + 1e-9).all()
    assert mouth.lips.nearest(points + pushes)[0].max() < 1e-12


def test_what_is_before_the_rim_of_a_lip_stays(opened):
    mouth, rim, normals = opened
    assert not mouth.pushes(rim + DEPTH * normals, APART).any()


def test_what_was_pushed_as_far_as_it_may_be_in_the_wall_is_not_pushed_again(opened):
    mouth, rim, normals = opened
    points = rim - 2 * DEPTH * normals
    margin = -DEPTH / 2
    pushed = points + mouth.pushes(points, margin)
    assert np.linalg.norm(mouth.pushes(pushed, margin), axis=1).max() < 1e-12


def test_a_mouth_whose_lips_are_not_named_has_no_rims():
    template = load_head().template()
    ids = template.annotation.regions["inner_mouth"]
    regions = {name: rows for name, rows in template.annotation.regions.items() if name != "mouth"}
    plain = replace(template, annotation=replace(template.annotation, regions=regions))
    pocket = Pocket(plain, ids)
    mouth = Mouth(pocket, plain.vertices[pocket.lips.ids])
    assert not len(pocket.rims)
    pushes = mouth.pushes(plain.vertices[ids], APART)
    assert np.isfinite(pushes).all()
