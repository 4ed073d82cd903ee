from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError, NumericsError
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.rig.head_expressions import head_expressions
from caricli.methods.rig.make_rig import RigSettings, make_rig
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.structures import Material, Mesh, Pictures
from caricli.structures.mesh import triangle_fans

BALL = 314  # vertices of an eyeball


@pytest.fixture(scope="module")
def templates(head, head_template):
    """Four expressions, those of eyes and mouth."""
    full = head_expressions(head, head_template)
    order = [full.names.index(name) for name in ("eyeBlinkLeft", "eyeLookInLeft", "jawOpen", "mouthClose")]
    return ExpressionTemplates(tuple(full.names[k] for k in order), full.mesh, full.deltas[order])


@pytest.fixture(scope="module")
def deltas(templates, face):
    return transfer_rig(templates, face.vertices)


@pytest.fixture(scope="module")
def face(head, head_template):
    return head_template.with_vertices(head.evaluate(gender=0.1, age=0.9, weight=0.8) * [1.1, 0.9, 1.2])


def test_a_rig_is_expressions_eyes_and_picture(templates, face, deltas):
    texture = np.full((8, 8, 3), 90, np.uint8)
    result = make_rig(face, templates, pictures=Pictures(skin=texture))
    rig, measures, balls = result.rig, result.measures, result.eyeballs
    assert rig.names == templates.names
    assert len(rig.neutral) == 4200 + 2 * BALL and [b.side for b in balls] == ["left", "right"]
    np.testing.assert_allclose(rig.neutral[:4200], face.vertices, atol=1e-7)
    np.testing.assert_allclose(rig.deltas[:, :4200], deltas, atol=1e-7)
    np.testing.assert_array_equal(rig.pictures.skin, texture)
    np.testing.assert_array_equal(rig.mesh.polygons[: len(face.polygons)], face.polygons)
    # Of these expressions one turns an eye, the left one.
    moving = rig.deltas.any(2)
    assert moving[1, 4200 : 4200 + BALL].any() and not moving[:, 4200 + BALL :].any()
    assert measures.lid_gap["left"] < 0.02 and measures.lip_gap < 0.1 and measures.inside < 0
    assert set(measures.lid_gap) == {"left"} and measures.flipped.max() < 0.002


def test_without_eyes(templates, face, deltas):
    bare = make_rig(face, templates, RigSettings(eyeballs=False), deltas=deltas)
    rig = bare.rig
    assert len(rig.neutral) == 4200 and bare.eyeballs == [] and bare.measures.inside is None
    assert rig.materials is rig.pictures.eyes is rig.pictures.skin is None
    np.testing.assert_array_equal(rig.faces, face.faces)
    nameless = replace(templates, mesh=Mesh(templates.neutral, templates.mesh.polygons))
    unknown = make_rig(face, nameless, deltas=deltas)
    np.testing.assert_array_equal(unknown.rig.deltas, rig.deltas)
    assert unknown.eyeballs == [] and unknown.measures.lid_gap == {} and len(unknown.rig.neutral) == 4200


def test_finer_meshes_do_the_same(templates, face, deltas):
    coarse, fine = (make_rig(face, templates, RigSettings(levels), deltas=deltas).rig for levels in (0, 1))
    count = len(fine.neutral) - 2 * BALL
    assert count > 3 * 4200
    for key in ("neutral", "deltas"):
        np.testing.assert_allclose(getattr(fine, key)[..., :4200, :], getattr(coarse, key)[..., :4200, :], atol=1e-7)
        # Eyes are as fine as they are, and what is new lies between what was there.
        np.testing.assert_array_equal(getattr(fine, key)[..., count:, :], getattr(coarse, key)[..., 4200:, :])
    edge = coarse.mesh.polygons[0, :2]
    middle = coarse.neutral[edge].astype(float).mean(0)
    at = np.linalg.norm(fine.neutral - middle, axis=1).argmin()
    np.testing.assert_allclose(fine.neutral[at], middle, atol=1e-6)
    np.testing.assert_allclose(fine.deltas[:, at], coarse.deltas[:, edge].astype(float).mean(1), atol=1e-6)
    skin = fine.mesh.polygons[fine.materials != Material.EYE]
    np.testing.assert_array_equal(fine.mesh.faces[: len(triangle_fans(skin))], triangle_fans(skin))


def test_the_scale_of_the_face_is_no_strength(templates, face):
    larger = face.with_vertices(3 * face.vertices)
    one, three = (make_rig(mesh, templates).measures for mesh in (face, larger))
    np.testing.assert_allclose(three.strength, one.strength, rtol=1e-3)
    assert 0.5 < one.strength.min() and one.strength.max() < 2


def test_a_triangle_without_area_is_refused(templates, face, deltas):
    flat = face.vertices.copy()
    flat[face.faces[9, 0]] = flat[face.faces[9, 1]]
    with pytest.raises(NumericsError, match="triangles without area"):
        make_rig(face.with_vertices(flat), templates, deltas=deltas)


def test_without_templates_it_does_arkits_52(face, head):
    rig = make_rig(face, settings=RigSettings(eyeballs=False)).rig
    assert rig.names == head.action_names and len(rig.neutral) == 4200


def test_another_topology_is_refused(templates, ball):
    with pytest.raises(InputError, match="expected the topology of the templates .* found another .300 vertices, 596"):
        make_rig(Mesh(*ball), templates)
