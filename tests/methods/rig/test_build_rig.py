from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.io.rig import rig_problem
from caricli.methods.rig.build_rig import build_rig
from caricli.methods.rig.expression_templates import ExpressionTemplates, mended_templates
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.structures import Material
from caricli.structures.mesh import triangle_fans

BALL = 314  # vertices of an eyeball


@pytest.fixture(scope="module")
def templates(head, head_template):
    """Four expressions, those of eyes and mouth."""
    full = mended_templates(head, head_template)
    order = [full.names.index(name) for name in ("eyeBlinkLeft", "eyeLookInLeft", "jawOpen", "mouthClose")]
    return ExpressionTemplates(tuple(full.names[k] for k in order), full.neutral, full.faces, full.deltas[order])


@pytest.fixture(scope="module")
def deltas(templates, face):
    return transfer_rig(templates, face.vertices)


@pytest.fixture(scope="module")
def face(head, head_template):
    return head_template.with_vertices(head.evaluate(gender=0.1, age=0.9, weight=0.8) * [1.1, 0.9, 1.2])


def generator():
    return np.random.default_rng(0)


def test_a_rig_is_expressions_eyes_and_picture(templates, face, deltas):
    texture = np.full((8, 8, 3), 90, np.uint8)
    rig, measures, balls = build_rig(face, templates, deltas, generator(), texture=texture)
    assert rig_problem(rig) is None and rig.names == templates.names
    assert len(rig.neutral) == 4200 + 2 * BALL and [b.side for b in balls] == ["left", "right"]
    np.testing.assert_allclose(rig.neutral[:4200], face.vertices, atol=1e-7)
    np.testing.assert_allclose(rig.deltas[:, :4200], deltas, atol=1e-7)
    np.testing.assert_array_equal(rig.texture, texture)
    np.testing.assert_array_equal(rig.mesh.polygons[: len(face.polygons)], face.polygons)
    # Of these expressions one turns an eye, the left one.
    moving = rig.deltas.any(2)
    assert moving[1, 4200 : 4200 + BALL].any() and not moving[:, 4200 + BALL :].any()
    assert measures.lid_gap["left"] < 0.02 and measures.lip_gap < 0.1 and measures.inside < 0
    assert set(measures.lid_gap) == {"left"} and measures.flipped.max() < 0.002


def test_without_eyes(templates, face, deltas):
    rig, measures, balls = build_rig(face, templates, deltas, generator(), eyeballs=False)
    assert len(rig.neutral) == 4200 and balls == [] and measures.inside is None
    assert rig.materials is rig.eye_texture is rig.texture is None
    np.testing.assert_array_equal(rig.faces, face.faces)
    unknown, measures, balls = build_rig(replace(face, annotation=None), templates, deltas, generator())
    np.testing.assert_array_equal(unknown.deltas, rig.deltas)
    assert balls == [] and measures.lid_gap == {} and len(unknown.neutral) == 4200


def test_finer_meshes_do_the_same(templates, face, deltas):
    coarse, fine = (build_rig(face, templates, deltas, generator(), levels)[0] for levels in (0, 1))
    count = len(fine.neutral) - 2 * BALL
    assert rig_problem(fine) is None and count > 3 * 4200
    for key in ("neutral", "deltas"):
        np.testing.assert_allclose(getattr(fine, key)[..., :4200, :], getattr(coarse, key)[..., :4200, :], atol=1e-7)
        # Eyes are as fine as they are, and what is new lies between what was there.
        np.testing.assert_array_equal(getattr(fine, key)[..., count:, :], getattr(coarse, key)[..., 4200:, :])
    edge = coarse.polygons[0, :2]
    middle = coarse.neutral[edge].astype(float).mean(0)
    at = np.linalg.norm(fine.neutral - middle, axis=1).argmin()
    np.testing.assert_allclose(fine.neutral[at], middle, atol=1e-6)
    np.testing.assert_allclose(fine.deltas[:, at], coarse.deltas[:, edge].astype(float).mean(1), atol=1e-6)
    skin = fine.mesh.polygons[fine.materials != Material.EYE]
    np.testing.assert_array_equal(fine.mesh.faces[: len(triangle_fans(skin))], triangle_fans(skin))


def test_the_scale_of_the_face_is_no_strength(templates, face):
    larger = face.with_vertices(3 * face.vertices)
    moves = [(mesh, transfer_rig(templates, mesh.vertices)) for mesh in (face, larger)]
    one, three = (build_rig(mesh, templates, deltas, generator())[1] for mesh, deltas in moves)
    np.testing.assert_allclose(three.strength, one.strength, rtol=1e-3)
    assert 0.5 < one.strength.min() and one.strength.max() < 2


def test_a_triangle_without_area_is_refused(templates, face, deltas):
    flat = face.vertices.copy()
    flat[face.faces[9, 0]] = flat[face.faces[9, 1]]
    with pytest.raises(NumericsError, match="triangles without area"):
        build_rig(face.with_vertices(flat), templates, deltas, generator())
