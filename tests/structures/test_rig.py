import dataclasses

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.limits import MAX_SHAPES
from caricli.structures import Material, Mesh, Pictures, Rig

VERTICES = np.random.default_rng(0).random((6, 3)).astype(np.float32)
POLYGONS = np.array([[0, 1, 2, 3], [3, 4, 5, -1]], np.int32)
PICTURE = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)


def full():
    generator = np.random.default_rng(1)
    return Rig(
        ("jawOpen", "grin", "tongueOut", "still"),
        Mesh(VERTICES, POLYGONS),
        generator.normal(size=(4, 6, 3)).astype(np.float32),
        materials=np.array([Material.SKIN, Material.EYE], np.int32),
        pictures=Pictures(PICTURE, PICTURE[:, :1]),
        normal_deltas=generator.normal(size=(4, 7, 3)).astype(np.float32),
    )


def test_the_mesh_is_the_neutral_face():
    rig = full()
    assert rig.neutral is rig.mesh.vertices and rig.faces is rig.mesh.faces


def test_a_shape_is_the_neutral_and_its_displacement():
    np.testing.assert_array_equal(full().shape("grin"), VERTICES + full().deltas[1])
    with pytest.raises(InputError, match="expected one of the rig's 4 expressions, found 'frown'"):
        full().shape("frown")


def test_materials_of_triangles_follow_their_polygons():
    assert full().triangle_materials.tolist() == [Material.SKIN, Material.SKIN, Material.EYE]
    bare = dataclasses.replace(full(), materials=None)
    assert bare.triangle_materials.tolist() == [Material.SKIN] * 3


def test_every_material_has_its_picture():
    assert full().pictures.of(Material.SKIN) is full().pictures.skin is PICTURE
    assert full().pictures.of(Material.EYE).shape == (2, 1, 3)
    assert dataclasses.replace(full(), pictures=Pictures(PICTURE)).pictures.of(Material.EYE) is None


def test_a_head_may_keep_still():
    still = Rig((), full().mesh, np.zeros((0, 6, 3)))
    assert still.materials is still.pictures.skin is still.normal_deltas is None


def bad(array, value, at=0):
    array = array.copy()
    array.flat[at] = value
    return array


CASES = [
    (lambda r: {"names": r.names[:3]}, "deltas: expected the shape (3, "),
    (lambda r: {"names": ()}, "deltas: expected the shape (0, "),
    (lambda r: {"names": (*r.names[:3], "jawOpen")}, "distinct names"),
    (lambda r: {"names": (*r.names[:3], "")}, "distinct names"),
    (lambda r: {"names": (*r.names[:3], 3)}, "distinct names"),
    (lambda r: {"names": [*r.names]}, "distinct names"),
    (lambda r: {"names": tuple(map(str, range(MAX_SHAPES + 1)))}, f"at most {MAX_SHAPES} distinct names"),
    (lambda r: {"mesh": r.mesh.with_vertices(bad(r.neutral, np.nan))}, "vertices: expected finite"),
    (lambda r: {"mesh": Mesh(r.neutral[:, :2], r.faces)}, "vertices: expected (V,3)"),
    (lambda r: {"mesh": Mesh(r.neutral, bad(r.faces, 10**6))}, "polygons: expected indices below"),
    (lambda r: {"deltas": bad(r.deltas, np.inf)}, "deltas: expected finite"),
    (lambda r: {"deltas": r.deltas * np.nan}, "deltas: expected finite"),
    (lambda r: {"deltas": r.deltas[:, :-1]}, "deltas: expected the shape"),
    (lambda r: {"deltas": r.deltas[:-1]}, "deltas: expected the shape"),
    (
        lambda r: {"materials": bad(r.materials, 99)},
        "materials: expected [0, 1, 2, 3, 4, 5, 6, 7, 8] for every polygon",
    ),
    (lambda r: {"materials": r.materials[:-1]}, "materials: expected"),
    (lambda r: {"normal_deltas": r.normal_deltas[:3]}, "normal_deltas: expected 4 displacements"),
    (lambda r: {"normal_deltas": r.normal_deltas[..., :2]}, "normal_deltas: expected 4 displacements"),
    (lambda r: {"normal_deltas": bad(r.normal_deltas, np.nan)}, "normal_deltas: expected finite coordinates"),
]


@pytest.mark.parametrize(("changes", "words"), CASES)
def test_what_is_no_rig_is_refused(changes, words):
    with pytest.raises(InputError) as caught:
        dataclasses.replace(full(), **changes(full()))
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_an_expression_in_use_is_on_top_of_what_it_is_meant_for():
    rig = dataclasses.replace(full(), names=("jawOpen", "mouthClose", "tongueOut", "still"))
    np.testing.assert_array_equal(rig.shape_in_use(1), rig.neutral + rig.deltas[0] + rig.deltas[1])
    np.testing.assert_array_equal(rig.shape_in_use(2), rig.shape("tongueOut"))
    alone = dataclasses.replace(rig, names=("a", "mouthClose", "b", "c"))
    np.testing.assert_array_equal(alone.shape_in_use(1), alone.shape("mouthClose"))


def test_a_rig_that_does_not_know_a_normal_face_says_so():
    assert full().require_normal_deltas().shape == (4, 7, 3)
    with pytest.raises(InputError, match="found none; caricli blendshapes writes one"):
        dataclasses.replace(full(), normal_deltas=None).require_normal_deltas()
