from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.methods.rig.expression_templates import (
    ExpressionTemplates,
    check_templates,
    contact_normals,
    thin_pairs,
)
from caricli.methods.rig.head_expressions import BLINKS, SEALED, MendSettings, head_expressions
from caricli.methods.rig.measure_rig import curve_gap
from caricli.structures import Mesh
from caricli.structures.arkit import ARKIT_NAMES
from caricli.template.head_parts import part_lips

_TOUCH = 2e-4


@pytest.fixture(scope="module")
def templates(head, head_template):
    return head_expressions(head, head_template)


@pytest.fixture
def plates():
    """Two plates of 6 x 6 vertices that face each other, 0.02 apart; shapes: one lifts the upper, one does nothing."""
    y, x = np.mgrid[:6, :6] * 0.2
    corner = (np.arange(5)[:, None] * 6 + np.arange(5)).ravel()
    quads = np.stack([corner, corner + 1, corner + 7, corner + 6], axis=1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    low = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    neutral = np.concatenate([low, low + [0, 0, 0.006]])
    deltas = np.zeros((3, 72, 3))
    deltas[0, 36:, 2] = 0.2
    deltas[2, 36:, 2] = -0.2
    mesh = Mesh(neutral, np.vstack([faces, faces[:, ::-1] + 36]))
    return ExpressionTemplates(("jawOpen", "nothing", "mouthClose"), mesh, deltas)


def test_the_heads_expressions_are_arkits(templates, head, head_template):
    assert templates.names == head.action_names and sorted(templates.names) == sorted(ARKIT_NAMES)
    np.testing.assert_array_equal(templates.neutral, head_template.vertices)
    assert templates.deltas.shape == (52, 4200, 3) and np.isfinite(templates.deltas).all()
    unmoved = (head.actions == 0).all((0, 2))
    assert templates.still[unmoved].all() and 500 < templates.still.sum() < 2000
    np.testing.assert_allclose(templates.deltas[:, templates.still], 0, atol=1e-12)


@pytest.mark.parametrize("side", ["left", "right"])
def test_lids_meet_where_the_head_s_own_pierce(templates, head, head_template, side):
    curves, k = head_template.annotation.curves, templates.names.index(f"eyeBlink{side.capitalize()}")
    upper, lower = curves[f"eye_upper_{side}"], curves[f"eye_lower_{side}"]
    shut, raw = (templates.neutral + d for d in (templates.deltas[k], head.actions[k].astype(float)))
    assert curve_gap(shut, upper, lower) < 0.02 * curve_gap(templates.neutral, upper, lower)
    # At full strength the upper lid is below the lower one.
    assert (raw[upper[1:-1], 1] - raw[lower[1:-1], 1]).min() < -1e-3
    assert (shut[upper[1:-1], 1] - shut[lower[1:-1], 1]).min() > -1e-4


def test_only_blinks_are_weaker_and_only_lips_and_lids_differ(templates, head, head_template):
    near = head_template.mask("mouth", "lips", "eyes_left", "eyes_right", "inner_mouth")
    for k, name in enumerate(templates.names):
        strength = MendSettings.blink if name in BLINKS else 1.0
        # Lips part for the tongue, which the head's own comes through.
        usual = part_lips(templates.names, templates.deltas) if name == "tongueOut" else strength * head.actions[k]
        change = np.abs(templates.deltas[k] - usual).max(1)
        assert change.max() < 4e-3 and change[~near].max() < (3e-3 if name in BLINKS else 1e-3), name
    for name in ("browInnerUp", "jawOpen", "eyeWideLeft"):
        k = templates.names.index(name)
        np.testing.assert_allclose(templates.deltas[k], head.actions[k], atol=1e-9)


def test_no_expression_pushes_lips_through_each_other(templates, head):
    from caricli.geometry.repair.contact_pairs import touching_pairs

    lips = touching_pairs(templates.neutral, templates.faces, templates.reach)
    normals = contact_normals(templates.mesh, lips, templates.reach)

    def least(deltas):
        """How near pairs come along their normals, over what they may, at worst."""
        worst = 0.0
        for k in range(52):
            shape = templates.start(k) + deltas[k]
            rest, gaps = (((v[lips[:, 0]] - v[lips[:, 1]]) * normals).sum(1) for v in (templates.neutral, shape))
            worst = min(worst, (gaps - np.minimum(rest, _TOUCH)).min())
        return worst

    assert least(templates.deltas) > -1e-4 > -2e-3 > least(head.actions.astype(float))


def test_lips_that_are_pressed_part_no_farther_than_at_rest(templates, head):
    from caricli.geometry.repair.contact_pairs import touching_pairs

    lips = touching_pairs(templates.neutral, templates.faces, templates.reach)
    normals = contact_normals(templates.mesh, lips, templates.reach)
    for name in SEALED:
        k = templates.names.index(name)
        parted, raw = (
            ((moved[k, lips[:, 0]] - moved[k, lips[:, 1]]) * normals).sum(1).max()
            for moved in (templates.deltas, head.actions.astype(float))
        )
        assert parted < 2e-4 < 3e-4 < raw, name


def test_pairs_are_vertices_of_lids_and_lips(templates, head_template):
    assert 200 < len(templates.pairs) < 800
    assert (templates.pairs[:, 0] != templates.pairs[:, 1]).all()
    np.testing.assert_allclose(np.linalg.norm(templates.normals, axis=1), 1)
    upper = head_template.annotation.curves["eye_upper_left"][1:-1]
    motion = templates.motions[templates.names.index("eyeBlinkLeft")]
    assert np.isin(upper, templates.pairs[motion.closed]).mean() > 0.3
    other = head_template.annotation.curves["eye_upper_right"]
    assert not np.isin(other, templates.pairs[motion.closed]).any()


def test_an_addition_starts_from_its_base(plates):
    np.testing.assert_array_equal(plates.start(0), plates.neutral)
    np.testing.assert_array_equal(plates.start(2), plates.neutral + plates.deltas[0])
    alone = replace(plates, names=("mouthClose",), deltas=plates.deltas[2:])
    np.testing.assert_array_equal(alone.start(0), plates.neutral)
    assert replace(plates, names=("MouthClose", "nothing", "JawOpen")).order == [1, 2, 0]


def test_motions_hold_what_changes(plates):
    np.testing.assert_array_equal(plates.still, np.arange(72) < 36)
    opens, nothing, closes = plates.motions
    assert nothing is None
    assert (plates.faces[opens.triangles] >= 36).all() and len(opens.triangles) == 50
    np.testing.assert_allclose(opens.maps, np.broadcast_to(np.eye(3), (50, 3, 3)), atol=1e-12)
    np.testing.assert_array_equal(opens.moved, plates.deltas[0])
    np.testing.assert_array_equal(opens.near, np.arange(72) >= 36)
    np.testing.assert_array_equal(opens.trust, np.arange(72) >= 36)
    # mouthClose undoes jawOpen to the neutral face: there is nothing to hold, but for what is closed.
    assert closes is None


@pytest.mark.parametrize("names", [("jawOpen", "nothing", "mouthClose"), ("JawOpen", "nothing", "mouth_close")])
def test_pairs_close_from_what_an_addition_starts_from(plates, names):
    deltas = plates.deltas.copy()
    deltas[2, 36:, 0] = 0.001
    closes = replace(plates, names=names, deltas=deltas).motions[2]
    assert closes.closed.all() and len(closes.closed) == 36
    np.testing.assert_allclose(closes.offsets, np.tile([-0.001, 0, -0.006], (36, 1)), atol=1e-12)
    np.testing.assert_allclose(closes.gaps, 0.006, atol=1e-12)
    np.testing.assert_allclose(closes.moved, np.where(np.arange(72)[:, None] < 36, 0, [0.001, 0, 0]), atol=1e-12)


def test_sliding_on_each_other_is_no_closing(plates):
    # The upper plate goes three columns aside: its vertices meet others, but they touched before.
    deltas = np.where(np.arange(72)[:, None] < 36, 0, [0.6, 0, 0])[None]
    aside = ExpressionTemplates(("jawLeft",), plates.mesh, deltas)
    assert len(aside.pairs) == 36 and (aside.pairs[:, 1] - aside.pairs[:, 0] == 36).all()
    assert not aside.motions[0].closed.any()
    # From further away they close.
    lifted = [0, 0, 0.1] * (np.arange(72)[:, None] >= 36)
    apart = ExpressionTemplates(("a",), plates.mesh.with_vertices(plates.neutral + lifted), deltas - lifted)
    assert len(apart.pairs) == 18 and apart.motions[0].closed.all()


def test_what_hardly_moves_is_trusted_little(plates):
    deltas = np.zeros((1, 72, 3))
    deltas[0, :, 2] = np.where(np.arange(72) < 36, 0, np.linspace(0, 0.2, 72))
    deltas[0, 36, 2] = 0.004
    deltas[0, 37:41] = 0
    motion = ExpressionTemplates(("a",), plates.mesh, deltas).motions[0]
    size = np.linalg.norm(deltas[0], axis=1)
    assert (motion.trust[size >= 0.02] == 1).all() and 0 < motion.trust[36] < 0.2
    assert (motion.trust[size == 0] == 0).all()
    # Beside what moves, less with every ring, and nothing on the other plate.
    assert motion.near[37] == pytest.approx(0.8) and (motion.near[size > 0] == 1).all()
    assert (motion.near[:36] == 0).all()


def test_thinning_leaves_no_two_pairs_that_start_and_end_near_each_other():
    vertices = np.array([[0.1, 0, 0], [0.4, 0, 0], [0.1, 0, 2], [0.2, 0, 2.1], [0.1, 0, 3], [1.3, 0, 0]])
    pairs = np.array([[3, 1], [0, 2], [0, 4], [5, 2], [2, 1]])
    np.testing.assert_array_equal(thin_pairs(pairs, vertices, 1.1), [[0, 2], [5, 2]])
    np.testing.assert_array_equal(thin_pairs(pairs, vertices, 0.9), [[0, 2], [0, 4], [5, 2]])
    np.testing.assert_array_equal(thin_pairs(pairs, vertices, 1e-3), pairs)


def test_thinning_hangs_neither_on_the_place_nor_on_the_order():
    generator = np.random.default_rng(0)
    vertices = generator.random((200, 3))
    pairs = np.sort(np.argsort(generator.random((500, 200)), axis=1)[:, :2], axis=1)
    kept = np.unique(thin_pairs(pairs, vertices, 0.3), axis=0)
    assert len(kept) < 400
    for _ in range(3):
        turn, place = rotation_matrices(generator.normal(size=3)), generator.normal(size=3)
        order = generator.permutation(len(pairs))
        again = np.sort(thin_pairs(pairs[order][:, ::-1], vertices @ turn.T + place, 0.3), axis=1)
        np.testing.assert_array_equal(np.unique(again, axis=0), kept)


def test_normals_of_contacts(plates):
    pairs = np.stack([np.arange(36) + 36, np.arange(36)], axis=1)
    # Where they touch, by the surfaces' normals; from afar, by the line between them; never against the usual ones.
    np.testing.assert_allclose(contact_normals(plates.mesh, pairs, 0.1), np.tile([0, 0, 1.0], (36, 1)))
    aslant = plates.neutral + np.where(np.arange(72)[:, None] < 36, 0, [0.3, 0, 0.394])
    direction = np.array([0.3, 0, 0.4]) / 0.5
    aslant = plates.mesh.with_vertices(aslant)
    far = contact_normals(aslant, pairs, 0.1)
    np.testing.assert_allclose(far, np.tile(direction, (36, 1)), atol=1e-9)
    usual = np.array([direction, -direction, [0, 1.0, 0]])
    np.testing.assert_allclose(contact_normals(aslant, pairs[:3], 0.1, usual), usual, atol=1e-9)


def test_checked_templates_are_what_was_given(plates):
    made = check_templates(["a", "b", "c"], plates.mesh, plates.neutral + plates.deltas)
    assert made.names == ("a", "b", "c")
    np.testing.assert_allclose(made.deltas, plates.deltas, atol=1e-12)


def test_meshes_that_cannot_be_transferred_from_are_refused(plates):
    shapes = plates.neutral + plates.deltas

    def refused(match, neutral=plates.neutral, faces=plates.faces, shapes=shapes):
        with pytest.raises(InputError, match=match):
            check_templates(["a", "b", "c"], Mesh(neutral, faces), shapes)

    refused("at most two triangles on every edge, found 3 on one", faces=np.vstack([plates.faces, [0, 7, 50]]))
    flat = plates.neutral.copy()
    flat[6:8] = flat[0:2]
    refused("triangles with an area, found 3 without", neutral=flat)
    refused("every vertex in a triangle, found 1 without", neutral=np.vstack([plates.neutral, [9, 9, 9]]),
            shapes=np.concatenate([shapes, np.zeros((3, 1, 3))], axis=1))  # fmt: skip
    refused("expressions that move something, found 3 that do not", shapes=np.stack([plates.neutral] * 3))
