from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError, NumericsError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.io.gltf.write_gltf import shading_normals
from caricli.methods.rig.expression_templates import ExpressionTemplates, combine_templates
from caricli.methods.rig.head_expressions import head_expressions
from caricli.methods.rig.make_rig import RigSettings, make_rig
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.structures import Face, Hair, HeadChoice, Material, Mesh, Pictures, Rig
from caricli.structures.arkit import action_codes
from caricli.structures.head_choice import BARE
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
    result = make_rig(face, templates, RigSettings(head=HeadChoice(("skin", "eyes"))), Pictures(skin=texture))
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


def test_hair_under_the_skin_is_deeper_where_a_jaw_would_uncover_it(templates, face, deltas, cap):
    normals = shading_normals(Rig((), face, np.zeros((0, 4200, 3))))[0]
    opened = deltas[templates.names.index("jawOpen")]
    chin = np.argmin((opened * normals).sum(1))
    points = cap.shell.vertices.copy()
    points[-1] = face.vertices[chin] - 0.001 * normals[chin]
    hair = replace(cap, shell=cap.shell.with_vertices(points))
    rig = make_rig(
        face, templates, RigSettings(head=HeadChoice(("skin", "hair"))), deltas=deltas, given=Face(face, hair=hair)
    ).rig
    depth = (face.vertices[chin] - rig.neutral[-1]) @ normals[chin]
    assert depth == pytest.approx(0.006, abs=0.0005)


def test_a_whole_head_has_teeth_tongue_lashes_and_the_hair_of_the_face(templates, face, deltas, cap):
    result = make_rig(face, templates, deltas=deltas, given=Face(face, hair=cap))
    rig = result.rig
    assert set(rig.materials) == {*Material} - {Material.CLOTH}
    ends = {material: np.unique(rig.faces[rig.triangle_materials == material]) for material in Material}
    assert ends[Material.SKIN].max() == 4199 and ends[Material.HAIR].min() == len(rig.neutral) - len(cap.shell.vertices)
    opened = rig.deltas[rig.names.index("jawOpen")]
    lower, upper = (part(opened, rig, side) for side in ("lower", "upper"))
    # Teeth at the back are near the joint, and upper ones only make room for the lip.
    assert lower[:, 1].max() < 0 and lower[:, 1].min() < -0.005
    assert np.abs(upper).max() < 0.1 * np.abs(lower).max()
    blinked = rig.deltas[rig.names.index("eyeBlinkLeft"), ends[Material.LASHES]]
    assert 0.003 < np.abs(blinked).max() < 0.03
    assert not rig.deltas[:, ends[Material.HAIR]].any()
    # In another shape of the face all goes along.
    wide = result.shaped(Face(face, hair=cap).with_vertices(face.vertices * [1.2, 1, 1]))
    np.testing.assert_allclose(wide[:4200, 0], 1.2 * rig.neutral[:4200, 0], atol=1e-6)
    for material in (Material.TEETH, Material.LASHES, Material.HAIR):
        grown = np.ptp(wide[ends[material], 0]) / np.ptp(rig.neutral[ends[material], 0])
        assert 1.02 < grown < 1.25, material


def test_expressions_are_those_that_let_the_tongue_out(templates, face, deltas, monkeypatch):
    monkeypatch.setattr("caricli.methods.rig.make_rig.let_tongue_out", lambda *given: 1.5 * given[-1])
    rig = make_rig(face, templates, RigSettings(head=BARE), deltas=deltas).rig
    np.testing.assert_allclose(rig.deltas, 1.5 * deltas, atol=1e-7)


def test_a_mouth_that_opens_keeps_its_lining_behind_the_skin(templates, face, deltas):
    """Skin above the lip that the jaw presses in."""
    nose = face.vertices[face.annotation.landmarks[33]]
    skin = np.setdiff1d(np.arange(len(face.vertices)), face.region("inner_mouth"))
    pressed = deltas.copy()
    pressed[2, skin, 2] -= 0.03 * np.exp(-(((face.vertices[skin] - nose) / 0.012) ** 2).sum(1))
    rig = make_rig(face, templates, RigSettings(head=BARE), deltas=pressed).rig
    shape = (rig.neutral + rig.deltas[2]).astype(float)[: len(face.vertices)]
    moved = [np.abs(face.cavities.withdraw(s) - s).max() for s in (face.vertices + pressed[2], shape)]
    assert moved[0] > 0.005 and moved[1] < 1e-6


def test_teeth_show_as_in_a_picture_of_the_same_face_alone(templates, face, deltas):
    long = Face(face, teeth=np.array([0.02, 0.0]))
    usual = make_rig(face, templates, deltas=deltas).rig
    for given, lowered in ((long, True), (replace(long, mesh=face.with_vertices(1.01 * face.vertices)), False)):
        rig = make_rig(face, templates, deltas=deltas, given=given).rig
        drop = part(usual.neutral, usual, "upper")[:, 1].min() - part(rig.neutral, rig, "upper")[:, 1].min()
        assert (drop > 0.005) == lowered


def test_a_face_as_it_was_given_has_the_teeth_of_its_picture(templates, face, deltas):
    jaw = deltas[templates.names.index("jawOpen")]
    laughing = Face(face.with_vertices(face.vertices + 0.4 * jaw), teeth=np.array([0.02, 0.0]))
    result = make_rig(face, templates, deltas=deltas, given=laughing)
    alone = make_rig(laughing.mesh, templates, deltas=deltas, given=laughing).rig
    own = part(alone.neutral, alone, "upper")
    given = result.as_given(laughing)
    np.testing.assert_allclose(given[:4200], laughing.vertices, atol=1e-7)
    np.testing.assert_allclose(part(given, result.rig, "upper"), own, atol=1e-6)
    # Those of the neutral face stay behind its lips.
    assert part(result.shaped(laughing), result.rig, "upper")[:, 1].min() > own[:, 1].min() + 0.005


def test_the_neck_has_the_colours_of_the_skin(templates, face, deltas):
    brown = Pictures(np.full((64, 64, 3), (120, 80, 40), np.uint8))
    rig = make_rig(face, templates, pictures=brown, deltas=deltas).rig
    assert (rig.pictures.bust == [120, 80, 40]).all()
    bare = make_rig(face, templates, RigSettings(head=BARE), brown, deltas).rig
    assert bare.pictures.bust is None


def part(values, rig, side):
    """Values of the teeth of one row."""
    ids = np.unique(rig.faces[rig.triangle_materials == Material.TEETH])
    return values[ids[: len(ids) // 2] if side == "upper" else ids[len(ids) // 2 :]]


@pytest.fixture(scope="module")
def cap(face):
    """Hair of the topmost triangles, a centimetre above the skin."""
    roots = face.faces[face.vertices[face.faces][..., 1].mean(1).argsort()[-200:]]
    used, faces = np.unique(roots, return_inverse=True)
    faces = faces.reshape(roots.shape).astype(np.int32)
    shell = Mesh(face.vertices[used] + [0, 0.01, 0], faces, np.zeros((1, 2)), 0 * faces)
    return Hair(shell, np.repeat(used[:, None], 3, 1).astype(np.int32), np.full((len(used), 3), 1 / 3))


def test_without_eyes(templates, face, deltas):
    bare = make_rig(face, templates, RigSettings(head=BARE), deltas=deltas)
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
    count = len(fine.neutral) - (len(coarse.neutral) - 4200)
    assert count > 3 * 4200
    for key in ("neutral", "deltas"):
        np.testing.assert_allclose(getattr(fine, key)[..., :4200, :], getattr(coarse, key)[..., :4200, :], atol=1e-7)
        # Eyes and teeth are as fine as they are, and what is new lies between what was there.
        np.testing.assert_array_equal(getattr(fine, key)[..., count:, :], getattr(coarse, key)[..., 4200:, :])
    edge = coarse.mesh.polygons[0, :2]
    middle = coarse.neutral[edge].astype(float).mean(0)
    at = np.linalg.norm(fine.neutral - middle, axis=1).argmin()
    np.testing.assert_allclose(fine.neutral[at], middle, atol=1e-6)
    np.testing.assert_allclose(fine.deltas[:, at], coarse.deltas[:, edge].astype(float).mean(1), atol=1e-6)
    skin = fine.mesh.polygons[fine.materials == Material.SKIN]
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
    rig = make_rig(face, settings=RigSettings(head=BARE)).rig
    assert rig.names == head.action_names and len(rig.neutral) == 4200


def test_eyes_and_tongue_go_by_what_an_expression_is_made_of(face, head, head_template):
    """By whatever name; half of an action is half of it."""
    full = head_expressions(head, head_template)
    names = ("eyeLookOutLeft", "eyeLookInRight", "eyeLookUpLeft", "tongueOut")
    rows = [full.names.index(name) for name in names]
    looks = {"eyeLookOutLeft": 1.0, "eyeLookInRight": 1.0}
    made_of = {"glance": looks, "eyeLookUpLeft": {"eyeLookUpLeft": 0.5}, "bleh": {"tongueOut": 1.0}}
    made_of |= {"tip": {"tongueOut": 0.5}, "smile": {"mouthSmileLeft": 0.7, "mouthSmileRight": 0.7}}
    choice = RigSettings(head=HeadChoice(("skin", "eyes", "teeth", "tongue")))
    mixed = make_rig(face, combine_templates(full, made_of), choice).rig
    plain = make_rig(face, ExpressionTemplates(names, full.mesh, full.deltas[rows]), choice).rig
    moves, single = (dict(zip(rig.names, rig.deltas, strict=True)) for rig in (mixed, plain))
    eyes, tongue = (
        np.unique(mixed.faces[mixed.triangle_materials == kind]) for kind in (Material.EYE, Material.TONGUE)
    )
    np.testing.assert_allclose(moves["glance"][eyes], sum(single[name] for name in looks)[eyes], atol=1e-7)
    up = np.linalg.norm([moves["eyeLookUpLeft"][eyes], single["eyeLookUpLeft"][eyes]], axis=2).max(1)
    assert 0.45 < up[0] / up[1] < 0.55
    out = [np.linalg.norm(each[tongue], axis=1).max() for each in (moves["tip"], moves["bleh"], single["tongueOut"])]
    assert 0.3 * out[1] < out[0] < 0.7 * out[1] and abs(out[1] - out[2]) < 0.1 * out[2]
    np.testing.assert_array_equal(mixed.actions, action_codes([*made_of.values()]))
    assert plain.actions is None


def test_a_face_that_lies_on_its_back_wears_its_skin_alone(templates, face):
    """As of programs whose z is up; one that is only inclined is as good as any."""
    lying, inclined = (
        face.with_vertices(face.vertices @ rotation_matrices(np.radians([turn, 0, 0])).T) for turn in (90, 20)
    )
    with pytest.raises(InputError, match=r"looks to \+z and has \+y up.*found one turned by 9. degrees"):
        make_rig(lying, templates)
    assert len(make_rig(lying, templates, RigSettings(head=BARE)).rig.neutral) == 4200
    assert len(make_rig(inclined, templates).rig.neutral) > 4200


def test_another_topology_is_refused(templates, ball):
    with pytest.raises(InputError, match="expected the topology of the templates .* found another .300 vertices, 596"):
        make_rig(Mesh(*ball), templates)
    vertices, faces = templates.neutral, templates.faces
    whole = Mesh(np.concatenate([vertices, vertices]), np.concatenate([faces, faces + len(vertices)]))
    with pytest.raises(InputError, match=r"\(--templates\), or of a whole head its skin, as --parts skin writes it"):
        make_rig(whole, templates)
    quads = templates.mesh.polygons
    cut = Mesh(vertices, np.concatenate([quads[:, [0, 1, 3]], quads[:, 1:]]))
    with pytest.raises(InputError, match=r"\(--templates\), or export quads, which were cut into other triangles"):
        make_rig(cut, templates)
