from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import InputError
from caricli.geometry.repair.components import mesh_components
from caricli.methods.parts.attachment import Attachment, attachment_for, open_head_attachment
from caricli.methods.parts.bones import PRESSED, Bone
from caricli.methods.parts.incisors import incisors_of
from caricli.methods.parts.pocket import Mouths, Pocket
from caricli.methods.parts.posed import Posed
from caricli.structures import Material, Mesh
from caricli.structures.arkit import alone
from caricli.template.head import load_head
from caricli.template.head_parts import head_parts


@pytest.fixture(scope="module")
def head():
    return load_head()


@pytest.fixture(scope="module")
def template(head):
    return head.template()


def by_name(parts):
    return {part.name: part for part in parts}


def test_on_the_template_parts_are_where_the_template_has_them(head, template):
    parts = open_head_attachment().attach(template)
    assert [part.name for part in parts] == ["teeth_upper", "teeth_lower", "tongue", "lashes"]
    for part, own in zip(parts, head_parts(head), strict=True):
        away = np.abs(part.mesh.vertices - own.mesh.vertices).max(1)
        # A little of the lower gums gives way to the lip, and a few lashes at the corners of the eyes to the lids.
        assert away.max() < {"teeth_lower": 0.004, "lashes": 0.001}.get(part.name, 1e-9) * template.height
        assert (away < 1e-4 * template.height).mean() > 0.9
        assert part.names == () and part.deltas.shape == (0, len(part.mesh.vertices), 3)
        assert part.mesh.uvs is not None


def test_they_go_wherever_the_head_goes(template):
    turn = Rotation.from_rotvec([0.3, -0.4, 1.0]).as_matrix()
    moved = template.with_vertices(1.7 * template.vertices @ turn.T + [0.1, 0.2, 0.3])
    pairs = zip(open_head_attachment().attach(template), attachment_for(template).attach(moved), strict=True)
    for before, after in pairs:
        expected = 1.7 * before.mesh.vertices @ turn.T + [0.1, 0.2, 0.3]
        assert np.abs(after.mesh.vertices - expected).max() < 1e-9


def test_expressions_move_bone_rigidly_and_the_tongue_comes_out(head, template):
    parts = by_name(open_head_attachment().animate(template, alone(head.action_names), head.actions))
    names = list(head.action_names)
    crowns = np.unique(parts["teeth_upper"].mesh.polygons[parts["teeth_upper"].materials == Material.TEETH])
    assert np.abs(parts["teeth_upper"].deltas[names.index("jawOpen"), crowns]).max() < 1e-4
    for name in ("teeth_lower", "tongue"):
        start = parts[name].mesh.vertices
        open_ = start + parts[name].deltas[names.index("jawOpen")]
        firm = np.unique(parts[name].mesh.polygons[parts[name].materials != Material.GUMS])[::7]
        lengths = [np.linalg.norm(np.diff(shape[firm], axis=0), axis=1) for shape in (start, open_)]
        assert np.allclose(*lengths, atol=2e-4) and (open_[:, 1].mean() - start[:, 1].mean()) < -0.01
    tip = parts["tongue"].mesh.vertices[:, 2].argmax()
    assert parts["tongue"].deltas[names.index("tongueOut"), tip, 2] > 0.015
    shut = parts["lashes"].deltas[names.index("eyeBlinkLeft")]
    left = parts["lashes"].mesh.vertices[:, 0] > 0
    assert shut[left, 1].min() < -0.008 and np.abs(shut[~left]).max() < 1e-3


def test_lashes_of_huge_eyes_are_no_longer_than_usual(template):
    def lengths(mesh):
        lashes = by_name(open_head_attachment().attach(mesh))["lashes"].mesh
        labels = mesh_components(lashes.vertices, lashes.faces).labels
        return np.array([np.ptp(lashes.vertices[labels == k], axis=0).max() for k in range(labels.max() + 1)])

    eyes = template.mask("eyes_left", "eyes_right")
    middle = template.vertices[eyes].mean(0)
    wide = np.where(eyes[:, None], middle + 2 * (template.vertices - middle), template.vertices)
    usual = lengths(template)
    assert (lengths(template.with_vertices(wide)) < 1.5 * usual).all()


def test_materials_say_what_is_tooth_and_what_gum(head):
    parts = by_name(head_parts(head))
    assert set(parts["teeth_lower"].materials) == {Material.TEETH, Material.GUMS}
    assert set(parts["lashes"].materials) == {Material.LASHES}


def test_cartoon_teeth_stand_where_natural_ones_do(template):
    natural, cartoon = (by_name(attachment_for(template, teeth).attach(template)) for teeth in ("natural", "cartoon"))
    for name in ("teeth_upper", "teeth_lower"):
        ends = [[part.mesh.vertices.min(0), part.mesh.vertices.max(0)] for part in (natural[name], cartoon[name])]
        np.testing.assert_allclose(*ends, atol=0.003)
        crowns = [(part.materials == Material.TEETH).sum() for part in (natural[name], cartoon[name])]
        assert crowns[0] / 14 == crowns[1] / 10


def test_places_that_hardly_any_vertex_names_hold_parts_all_the_same(head, template):
    note = template.annotation
    sockets = {f"eyes_{side}": note.regions[f"eye_socket_{side}"] for side in ("left", "right")}
    regions = note.regions | sockets | {"inner_mouth": note.regions["inner_mouth"][:2]}
    few = replace(template, annotation=replace(note, regions=regions))
    own = [replace(part, names=(), deltas=part.deltas[:0]) for part in head_parts(head)]
    for part, place in zip(Attachment(few, own).attach(few), own, strict=True):
        assert np.abs(part.mesh.vertices - place.mesh.vertices).max() < 0.01 * template.height


def test_lashes_far_from_the_skin_are_refused(head, template):
    lashes = head_parts(head)[-1]
    mesh = lashes.mesh.with_vertices(lashes.mesh.vertices + [0, 0, 0.06])
    far = replace(lashes, mesh=mesh, names=(), deltas=lashes.deltas[:0])
    with pytest.raises(InputError, match="lashes: expected it to hang on lids, found no skin within 8 %"):
        Attachment(template, [far])


def test_another_topology_has_none(template):
    other = type(template)(
        template.vertices, template.polygons[:, ::-1].copy(), annotation=template.annotation
    )  # turned inside out
    assert attachment_for(other) is None
    with pytest.raises(InputError, match="--teeth, found another"):
        attachment_for(other, "natural")
    assert isinstance(template, Mesh)


def test_parts_stay_behind_a_lip_that_was_pushed_in(head, template):
    narrow = template.vertices.copy()
    wall = template.annotation.regions["inner_mouth"]
    lip = narrow[wall[narrow[wall, 2].argmax()]]
    narrow -= 0.02 * np.exp(-0.5 * (((narrow - lip) / 0.015) ** 2).sum(1))[:, None] * [0, 0, 1]
    face = template.with_vertices(narrow)
    attachment = open_head_attachment()
    deltas = np.asarray(head.actions, float)
    parts = attachment.animate(face, alone(head.action_names), deltas)
    pocket = Pocket(template, wall)
    mouths = Mouths(pocket, narrow, head.action_names, deltas)
    free = [part for part in parts if part.name != "lashes"]
    bones = [hold for hold in attachment.holds if isinstance(hold, Bone)]
    unaware = [bone.place(Posed(narrow, {}, np.zeros((0, *narrow.shape))), None) for bone in bones]
    assert max(-mouths.rest.room(part.mesh.vertices)[0].min() for part in unaware) > 0.005 * face.height
    for part in free:
        assert mouths.rest.room(part.mesh.vertices)[0].min() > -1e-4 * face.height
        for name in ("jawOpen", "mouthPucker", "mouthSmileLeft", "jawLeft", "mouthRollLower", "mouthClose"):
            k = head.action_names.index(name)
            for amount in (0.25, 0.5, 0.75, 1.0):
                moved = part.mesh.vertices + amount * np.tensordot(mouths.uses[k], part.deltas, 1)
                assert mouths.mouth(k, amount).room(moved)[0].min() > -0.003 * face.height


def test_an_expression_far_from_a_mouth_that_is_too_small_leaves_its_teeth(head, template):
    small = template.vertices.copy()
    wall = template.annotation.regions["inner_mouth"]
    middle = small[wall].mean(0)
    small[wall] = middle + (small[wall] - middle) * [0.8, 0.3, 0.8]
    small[wall] += np.random.default_rng(0).normal(0, 0.003, (len(wall), 3))
    names = ("browInnerUp", "browDownLeft", "jawOpen")
    deltas = np.asarray(head.actions, float)[[head.action_names.index(name) for name in names]]
    mouths = Mouths(Pocket(template, wall), small, names, deltas)
    for part in open_head_attachment().animate(template.with_vertices(small), alone(names), deltas)[:2]:
        assert mouths.rest.room(part.mesh.vertices)[0].min() < PRESSED * mouths.height, "no room for it at rest"
        moves = np.abs(part.deltas).max((1, 2))
        assert moves[:2].max() < 1e-9 and moves[2] > 1e-4, part.name


def test_lower_teeth_follow_the_jaw_where_cheeks_keep_the_molars(head, template):
    """Cheeks that close on the molars of a jaw which opens: the row becomes narrower behind, and is not held up."""
    wall = template.annotation.regions["inner_mouth"]
    names = ("jawOpen",)
    usual = np.asarray(head.actions, float)[[head.action_names.index(name) for name in names]]
    closing = usual.copy()
    places = template.vertices[wall]
    teeth = open_head_attachment().attach(template)[1].mesh.vertices
    behind = places[:, 2] < teeth[:, 2].mean()
    closing[0, wall[behind], 0] -= 0.02 * template.height * np.sign(places[behind, 0])
    incisors = incisors_of(template, open_head_attachment().attach(template)[1])
    assert incisors is not None
    expressions = alone(names)
    free, kept = (
        open_head_attachment().animate(template, expressions, deltas)[1].deltas[0] for deltas in (usual, closing)
    )
    assert kept[incisors.front, 1].mean() < 0.6 * free[incisors.front, 1].mean() < -0.01


def test_lower_lashes_are_shorter_and_finer_than_upper_ones(template):
    lashes = by_name(open_head_attachment().attach(template))["lashes"].mesh
    labels = mesh_components(lashes.vertices, lashes.faces).labels
    hairs = [lashes.vertices[labels == k] for k in range(labels.max() + 1)]
    # Rings from the root on, and the tip.
    rises = np.array([hair[-1, 1] - hair[:3, 1].mean() for hair in hairs])
    lengths = np.array([np.linalg.norm(hair[-1] - hair[:3].mean(0)) for hair in hairs])
    thickness = np.array([np.linalg.norm(hair[0] - hair[1]) for hair in hairs])
    assert 0.3 < (rises < 0).mean() < 0.7
    for values, most in ((lengths, 0.75), (thickness, 0.7)):
        assert np.median(values[rises < 0]) < most * np.median(values[rises > 0])


@pytest.mark.parametrize("size", [0.9, 2.0])
def test_a_head_of_another_size_has_its_parts_and_their_moves_in_that_size(size):
    head = load_head()
    template = head.template()
    # Of one that is its own mirror image rounding tells to which side a tongue goes.
    face = template.vertices * [1.1, 0.95, 0.9] + 0.05 * template.vertices[:, [1]] * [1, 0, 0]
    names = ("jawForward", "mouthSmileLeft", "tongueOut")
    deltas = head.actions[[head.action_names.index(name) for name in names]].astype(float)
    attachment = open_head_attachment()

    def dressed(times):
        mesh = template.with_vertices(times * face)
        opened = attachment.let_out(mesh, alone(names), times * deltas)
        return opened, attachment.animate(mesh, alone(names), opened)

    (opened, parts), (others_opened, others) = dressed(1.0), dressed(size)
    np.testing.assert_allclose(others_opened / size, opened, atol=1e-7)
    for part, other in zip(parts, others, strict=True):
        np.testing.assert_allclose(other.mesh.vertices / size, part.mesh.vertices, atol=1e-7)
        np.testing.assert_allclose(other.deltas / size, part.deltas, atol=1e-6)
