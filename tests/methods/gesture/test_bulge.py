from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.gesture.bulge import bulge
from caricli.methods.gesture.selection import Selection, mark_handles, select_region
from caricli.methods.gesture.settings import GestureSettings
from caricli.render.smooth_normals import smooth_normals
from tests.methods.gesture.conftest import mark, ring, view

CAVITIES = ("inner_mouth", "eye_socket_left", "eye_socket_right")


@pytest.fixture(scope="module")
def nose(face, head_template):
    camera = view()
    return select_region(face, camera, ring(mark(face, head_template, camera, 30), 35), Selection())


@pytest.mark.parametrize("level", [1, 2, 3, -1, -2, -3])
def test_it_goes_along_the_normals_and_turns_no_triangle_over(face, head_template, nose, level):
    changed = bulge(face, head_template, nose, level)
    tip = head_template.annotation.landmarks[30]
    moved = changed.face.vertices - face.vertices
    assert np.sign(moved[tip] @ smooth_normals(face.vertices, face.faces)[tip]) == np.sign(level)
    assert changed.share == 1 and 0.001 < changed.moved < 0.03
    gradients = head_template.gradients
    before, after = (flipped_triangles(each.vertices, gradients) for each in (face, changed.face))
    assert not (after & ~before).any()


def test_levels_grow(face, head_template, nose):
    for sign in (1, -1):
        first, second, third = (bulge(face, head_template, nose, sign * level).moved for level in (1, 2, 3))
        assert first < second < third


def test_what_is_beside_a_handle_goes_along_with_it(face, head_template, nose):
    tip = head_template.annotation.landmarks[30]
    changed = bulge(face, head_template, replace(nose, handles=np.array([tip])), 2)
    moved = np.linalg.norm(changed.face.vertices - face.vertices, axis=1)
    beside = np.unique(face.faces[(face.faces == tip).any(1)])
    assert moved[tip] == moved.max() and moved[beside].min() > 0.1 * moved[tip]


def test_outside_the_region_nothing_changes_by_a_bit(face, head_template, nose):
    outside = np.ones(len(face.vertices), bool)
    outside[nose.region] = False
    for name in CAVITIES:
        outside[head_template.annotation.regions[name]] = False  # pockets give way where they must
    changed = bulge(face, head_template, nose, 3)
    assert np.array_equal(changed.face.vertices[outside], face.vertices[outside])
    assert set(np.flatnonzero((changed.face.vertices != face.vertices).any(1))) <= set(nose.region.tolist())


def test_it_leaves_the_border_without_a_crease(face, head_template, nose):
    moved = np.linalg.norm(bulge(face, head_template, nose, 3).face.vertices - face.vertices, axis=1)
    inside = np.zeros(len(face.vertices), bool)
    inside[nose.region] = True
    rim = np.unique(face.faces[inside[face.faces].any(1) & ~inside[face.faces].all(1)])
    assert np.median(moved[rim]) < 0.1 * moved.max() and moved[rim].max() < 0.5 * moved.max()


def test_a_head_elsewhere_bulges_alike(face, head_template, nose):
    turn = rotation_matrices(np.array([0.3, -0.7, 0.2]))
    elsewhere = replace(face, mesh=face.mesh.with_vertices(face.vertices @ turn.T + [0.1, 0.2, -0.1]))
    here, there = (bulge(each, head_template, nose, 2).face.vertices for each in (face, elsewhere))
    np.testing.assert_allclose(here @ turn.T + [0.1, 0.2, -0.1], there, atol=1e-9)


def test_symmetric_is_the_same_on_both_sides(face, head_template):
    camera = view()
    cheek = select_region(face, camera, ring(mark(face, head_template, camera, 3) + [25, 0], 22), Selection())
    changed = bulge(face, head_template, cheek, 2, symmetric=True)
    mirror = head_template.annotation.mirror
    moved = changed.face.vertices - face.vertices
    np.testing.assert_allclose(moved[mirror] * [-1, 1, 1], moved, atol=2e-4)
    one = bulge(face, head_template, cheek, 2).face.vertices - face.vertices
    assert abs(np.abs(moved).max() / np.abs(one).max() - 1) < 0.1  # as high as alone


def test_handles_go_the_whole_way(face, head_template):
    camera = view()
    handles = mark_handles(face, camera, mark(face, head_template, camera, 30)[None], 12, Selection())
    changed = bulge(face, head_template, handles, 1)
    moved = np.linalg.norm(changed.face.vertices - face.vertices, axis=1)
    np.testing.assert_allclose(moved[handles.handles], moved.max(), rtol=1e-6)
    assert 0 < (moved == 0).mean() < 1


def test_what_cannot_bulge_is_refused(face, head_template, nose):
    with pytest.raises(InputError, match="level from 1 to 3"):
        bulge(face, head_template, nose, 0)
    with pytest.raises(InputError, match="found neither"):
        bulge(face, head_template, Selection(), 1)
    hidden = Selection(head_template.annotation.regions["inner_mouth"][:1])
    with pytest.raises(InputError, match="expected skin to bulge, found only what is hidden"):
        bulge(face, head_template, hidden, 1, settings=GestureSettings(reach=1e-6))
    chin = head_template.annotation.landmarks[[8]]
    with pytest.raises(InputError, match="expected handles within the region, found all of them outside"):
        bulge(face, head_template, replace(nose, handles=chin), 1)
