from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.rig.add_parts import add_parts, choose_parts
from caricli.structures import Camera, Depiction, HeadChoice, Material, Mesh, Part, Pictures, Rig
from caricli.structures.head_choice import BARE, WHOLE

SQUARE = np.array([[0, 1, 2, 3]], np.int32)
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def part(name, material, names=(), move=0.0):
    mesh = Mesh(CORNERS + [0, 0, -1], SQUARE, np.eye(1, 2), 0 * SQUARE)
    deltas = np.full((len(names), 4, 3), move)
    return Part(name, mesh, np.array([material], np.int32), "skull", names, deltas)


@pytest.fixture
def rig():
    deltas = np.ones((2, 4, 3), np.float32)
    return Rig(("smile", "jawOpen"), Mesh(CORNERS.astype(np.float32), SQUARE, CORNERS[:, :2], SQUARE), deltas)


def test_parts_come_after_the_skin_and_move_by_name(rig):
    parts = [part("lower", Material.TEETH, ("jawOpen", "other"), 0.5), part("gums", Material.GUMS)]
    whole = add_parts(rig, [*parts, part("upper", Material.TEETH)])
    assert whole.materials.tolist() == [Material.SKIN, Material.TEETH, Material.TEETH, Material.GUMS]
    np.testing.assert_array_equal(whole.mesh.polygons[:, 0], [0, 4, 12, 8])
    np.testing.assert_array_equal(whole.neutral[:4], rig.neutral)
    np.testing.assert_array_equal(whole.deltas[:, :4], rig.deltas)
    np.testing.assert_array_equal(whole.deltas[:, 4:8], [np.zeros((4, 3)), np.full((4, 3), 0.5)])
    assert not whole.deltas[:, 8:].any() and whole.deltas.dtype == np.float32
    assert add_parts(rig, []) is rig


def test_what_is_not_chosen_leaves_with_its_vertices(rig):
    parts = [part("tongue", Material.TONGUE, ("smile",), 0.25), part("teeth", Material.TEETH, ("smile",), 0.5)]
    whole = add_parts(rig, parts)
    bare = choose_parts(whole, HeadChoice(("skin", "teeth")))
    assert bare.materials.tolist() == [Material.SKIN, Material.TEETH] and len(bare.neutral) == 8
    np.testing.assert_array_equal(bare.neutral[bare.mesh.polygons], whole.neutral[whole.mesh.polygons[:2]])
    np.testing.assert_array_equal(bare.mesh.uvs[bare.mesh.uv_polygons], whole.mesh.uvs[whole.mesh.uv_polygons[:2]])
    np.testing.assert_array_equal(bare.deltas[0, 4:], np.full((4, 3), 0.5, np.float32))
    skin = choose_parts(whole, BARE)
    np.testing.assert_array_equal(skin.neutral, rig.neutral)
    np.testing.assert_array_equal(skin.deltas, rig.deltas)


def test_uvs_of_what_is_not_chosen_leave_too(rig):
    whole = add_parts(rig, [part("tongue", Material.TONGUE), part("teeth", Material.TEETH)])
    bare = choose_parts(whole, HeadChoice(("skin", "teeth")))
    np.testing.assert_array_equal(bare.mesh.uvs, whole.mesh.uvs[[0, 1, 2, 3, 5]])
    skin = choose_parts(whole, BARE)
    np.testing.assert_array_equal(skin.mesh.uvs, rig.mesh.uvs)
    np.testing.assert_array_equal(skin.mesh.uv_polygons, rig.mesh.uv_polygons)


def test_a_skin_that_is_left_alone_is_one_that_never_had_parts(rig):
    teeth = part("teeth", Material.TEETH)
    skin = choose_parts(add_parts(rig, [teeth]), BARE)
    assert skin.materials is None and choose_parts(skin, WHOLE) is skin
    assert add_parts(skin, [teeth]).materials.tolist() == [Material.SKIN, Material.TEETH]


def test_what_a_picture_shows_gets_and_loses_the_same_parts(rig):
    camera = Camera(1.0, np.diag([1.0, -1, -1]), np.zeros(2))
    seen = replace(rig, depiction=Depiction(camera, rig.neutral + np.float32(0.5)))
    whole = add_parts(seen, [part("tongue", Material.TONGUE), part("teeth", Material.TEETH)])
    np.testing.assert_array_equal(whole.depiction.vertices[:4], rig.neutral + 0.5)
    np.testing.assert_array_equal(whole.depiction.vertices[4:], whole.neutral[4:])
    bare = choose_parts(whole, HeadChoice(("skin", "teeth")))
    np.testing.assert_array_equal(bare.depiction.vertices, whole.depiction.vertices[[0, 1, 2, 3, 8, 9, 10, 11]])


def test_rounding_moves_no_part(rig):
    whole = add_parts(
        rig, [part("gums", Material.GUMS, ("smile",), 1e-7), part("teeth", Material.TEETH, ("smile",), 1e-5)]
    )
    assert not whole.deltas[0, 4:8].any() and (whole.deltas[0, 8:] == np.float32(1e-5)).all()


def test_who_has_all_that_is_chosen_stays_as_it_is(rig):
    whole = add_parts(rig, [part("teeth", Material.TEETH)])
    assert choose_parts(whole, WHOLE) is whole and choose_parts(rig, BARE) is rig


def test_polygons_of_three_corners_stay_what_they_are(rig):
    padded = np.array([[0, 1, 2, -1]], np.int32)
    mixed = replace(rig, mesh=Mesh(CORNERS[:3].astype(np.float32), padded), deltas=rig.deltas[:, :3])
    whole = add_parts(replace(mixed, pictures=Pictures()), [part("a", Material.TONGUE), part("b", Material.LASHES)])
    left = choose_parts(whole, HeadChoice(("skin", "lashes")))
    np.testing.assert_array_equal(left.mesh.polygons, [[0, 1, 2, -1], [3, 4, 5, 6]])
