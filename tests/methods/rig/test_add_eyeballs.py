from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.rig.add_eyeballs import ANGLES, CLEARANCE, Eyeball, add_eyeballs, fit_eyeballs, lid_vertices
from caricli.structures import Material, Mesh, Rig
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.mesh import triangle_fans

CENTRE = np.array([0.03, 0.1, 0.05])
BALLS = [Eyeball("left", CENTRE, 0.012, 0.0), Eyeball("right", CENTRE * [-1, 1, 1], 0.01, 0.0)]
SKIN_QUADS = np.array([[0, 1, 2, 3], [3, 2, 4, -1]], np.int32)


@pytest.fixture
def skin():
    """A face of a quad and a triangle with UVs and all of ARKit's names."""
    neutral = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 2, 0]], np.float32)
    deltas = np.random.default_rng(0).normal(size=(52, 5, 3)).astype(np.float32)
    uvs = neutral[:, :2].astype(float) / 2
    return Rig(ARKIT_NAMES, Mesh(neutral, SKIN_QUADS, uvs, SKIN_QUADS), deltas)


def balls_of(rig, skin):
    """Of both balls: vertices, displacements (52, N, 3)."""
    count = (len(rig.neutral) - len(skin.neutral)) // 2
    spans = [slice(len(skin.neutral) + k * count, len(skin.neutral) + (k + 1) * count) for k in (0, 1)]
    return [(rig.neutral[span].astype(float), rig.deltas[:, span].astype(float)) for span in spans]


def test_the_face_comes_first_and_as_it_was(skin):
    rig = add_eyeballs(skin, BALLS, np.random.default_rng(0))
    assert rig.names == skin.names
    np.testing.assert_array_equal(rig.neutral[:5], skin.neutral)
    np.testing.assert_array_equal(rig.deltas[:, :5], skin.deltas)
    np.testing.assert_array_equal(rig.mesh.polygons[:2], SKIN_QUADS)
    np.testing.assert_array_equal(rig.mesh.uv_polygons[:2], SKIN_QUADS)
    np.testing.assert_array_equal(rig.mesh.uvs[:5], skin.mesh.uvs)
    np.testing.assert_array_equal(rig.faces, triangle_fans(rig.mesh.polygons))
    np.testing.assert_array_equal(
        rig.materials, np.where(np.arange(len(rig.mesh.polygons)) < 2, Material.SKIN, Material.EYE)
    )


def test_balls_are_closed_spheres_that_look_outwards(skin):
    rig = add_eyeballs(skin, BALLS, np.random.default_rng(0))
    for ball, (points, _) in zip(BALLS, balls_of(rig, skin), strict=True):
        np.testing.assert_allclose(np.linalg.norm(points - ball.centre, axis=1), ball.radius, atol=1e-7)
        np.testing.assert_allclose(points[0], ball.centre + [0, 0, ball.radius], atol=1e-7)
    eyes = rig.faces[rig.faces.min(1) >= 5]
    edges = eyes[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    assert len(np.unique(edges, axis=0)) == len(edges)
    np.testing.assert_array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))
    a, b, c = np.moveaxis(rig.neutral[eyes].astype(float), 1, 0)
    centres = np.where(a[:, :1] > 0, BALLS[0].centre, BALLS[1].centre)
    assert ((np.cross(b - a, c - a) * (a + b + c - 3 * centres)).sum(1) > 0).all()


def test_the_picture_is_unrolled_from_the_pupil(skin):
    rig = add_eyeballs(skin, BALLS, np.random.default_rng(0))
    corners, rows = (
        rig.mesh.polygons[rig.materials == Material.EYE],
        rig.mesh.uv_polygons[rig.materials == Material.EYE],
    )
    half = len(corners) // 2
    np.testing.assert_array_equal(rig.mesh.uvs[rows[:half]], rig.mesh.uvs[rows[half:]])
    assert rows[corners >= 0].min() == 5 and rows.max() == len(rig.mesh.uvs) - 1
    assert rig.mesh.uvs.min() >= 0 and rig.mesh.uvs.max() <= 1
    front, used = corners[:half], corners[:half] >= 0
    towards = (rig.neutral[front[used]] - BALLS[0].centre) / BALLS[0].radius
    away = rig.mesh.uvs[rows[:half][used]] - 0.5
    # The distance from the middle is the angle from the front; up is up, and right is the subject's left.
    angles = np.arctan2(np.linalg.norm(towards[:, :2], axis=1), towards[:, 2])
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), angles / (2 * np.pi), atol=1e-5)
    along = towards[:, :2] / np.maximum(np.linalg.norm(towards[:, :2], axis=1, keepdims=True), 1e-2)
    assert ((away * along).sum(1) >= 0.99 * np.linalg.norm(away, axis=1))[np.abs(towards[:, 2]) < 0.999].all()
    # No polygon covers more of the picture than its share, those around the back neither.
    assert (
        np.ptp(np.where(used[..., None], rig.mesh.uvs[rows[:half]], rig.mesh.uvs[rows[:half, :1]]), axis=1).max() < 0.15
    )


def test_eyes_turn_where_the_name_says(skin):
    rig = add_eyeballs(skin, BALLS, np.random.default_rng(0))
    expected = {"Up": (1, 1), "Down": (1, -1), "In": (0, None), "Out": (0, None)}
    seen = set()
    for k, name in enumerate(rig.names):
        for ball, (points, deltas) in zip(BALLS, balls_of(rig, skin), strict=True):
            side, turned = ball.side.capitalize(), points + deltas[k]
            gaze = (turned[0] - ball.centre) / ball.radius
            direction = name.removeprefix("eyeLook").removesuffix(side)
            if not (name.startswith("eyeLook") and name.endswith(side)):
                np.testing.assert_array_equal(deltas[k], 0)
                continue
            seen.add(name)
            np.testing.assert_allclose(np.linalg.norm(turned - ball.centre, axis=1), ball.radius, atol=1e-7)
            angle = np.radians(max(np.abs(ANGLES[direction])))
            axis, sign = expected[direction]
            # The nose is at x = 0: the left eye, at +x, looks there by turning to -x.
            nose = -np.sign(ball.centre[0])
            sign = sign or {"In": nose, "Out": -nose}[direction]
            want = np.eye(3)[2] * np.cos(angle) + np.eye(3)[1 if axis else 0] * sign * np.sin(angle)
            np.testing.assert_allclose(gaze, want, atol=1e-5)
    assert len(seen) == 8


def test_a_face_without_uvs_gets_one_place_for_its_corners(skin):
    bare = replace(skin, mesh=Mesh(skin.neutral, SKIN_QUADS))
    rig = add_eyeballs(bare, BALLS[:1], np.random.default_rng(0))
    np.testing.assert_array_equal(rig.mesh.uv_polygons[:2], [[0, 0, 0, 0], [0, 0, 0, -1]])
    own = rig.mesh.uv_polygons[2:][rig.mesh.polygons[2:] >= 0]
    assert own.min() == 1 and own.max() == len(rig.mesh.uvs) - 1


@pytest.mark.parametrize("width", [3, 6])
def test_polygons_of_any_width(skin, width):
    rows = triangle_fans(SKIN_QUADS) if width == 3 else np.pad(SKIN_QUADS, ((0, 0), (0, 2)), constant_values=-1)
    mesh = Mesh(skin.neutral, rows, skin.mesh.uvs, rows)
    rig = add_eyeballs(replace(skin, mesh=mesh), BALLS, np.random.default_rng(0))
    assert rig.mesh.polygons.shape[1] == max(width, 4)
    np.testing.assert_array_equal(rig.mesh.polygons[: len(rows), :width], rows)
    np.testing.assert_array_equal(rig.faces, add_eyeballs(skin, BALLS, np.random.default_rng(0)).faces)


def test_no_eyes_change_nothing_and_the_seed_decides_the_picture(skin):
    assert add_eyeballs(skin, [], np.random.default_rng(0)) is skin
    one, same, other = (add_eyeballs(skin, BALLS, np.random.default_rng(seed)).pictures.eyes for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


def test_eyes_retreat_until_the_lids_clear_them(head_template):
    neutral, note = head_template.vertices, head_template.annotation
    lids = lid_vertices(note, "left")
    deltas = np.zeros((2, *neutral.shape))
    resting, other = fit_eyeballs(head_template, note, deltas)
    deltas[1, lids, 2] = -0.004
    pressed, still = fit_eyeballs(head_template, note, deltas)
    assert (pressed.side, still.side) == ("left", "right")
    assert pressed.retreat > resting.retreat + 0.002 and pressed.radius == resting.radius
    np.testing.assert_allclose(still.centre, other.centre)
    np.testing.assert_allclose(pressed.centre, resting.centre - [0, 0, pressed.retreat - resting.retreat])
    distance = np.linalg.norm(neutral[lids] + deltas[1, lids] - pressed.centre, axis=1).min()
    assert distance == pytest.approx(CLEARANCE * pressed.radius, rel=1e-6)


def test_eyes_retreat_for_lids_that_are_before_them_only_on_their_way(head_template):
    """From above to below, and between both flat."""
    note = head_template.annotation
    lids = lid_vertices(note, "left")
    deltas = np.zeros((1, *head_template.vertices.shape))
    resting = fit_eyeballs(head_template, note, deltas)[0]
    deltas[0, lids, 1] = 2 * (resting.centre[1] - head_template.vertices[lids, 1])
    ball = fit_eyeballs(head_template, note, deltas)[0]
    half = head_template.vertices[lids] + deltas[0, lids] / 2
    assert np.linalg.norm(half - ball.centre, axis=1).min() >= CLEARANCE * ball.radius - 1e-9
    assert ball.retreat > resting.retreat + 1e-4


def test_lids_are_no_lining(head_template):
    note = head_template.annotation
    for side in ("left", "right"):
        ids = lid_vertices(note, side)
        assert np.isin(note.curves[f"eye_upper_{side}"], ids).any()
        assert not np.isin(ids, note.regions[f"eye_socket_{side}"]).any()


@pytest.mark.parametrize("side", ["left", "right"])
def test_an_eye_that_is_known_alone_is_that_of_its_side(head_template, side):
    note = head_template.annotation
    other = "right" if side == "left" else "left"
    still = np.zeros((0, *head_template.vertices.shape))
    both = {ball.side: ball for ball in fit_eyeballs(head_template, note, still)}
    modelled = replace(note, regions=note.regions | {f"eyeball_{other}": np.zeros(0, int)})
    unnamed = replace(note, curves={name: ids for name, ids in note.curves.items() if not name.endswith(other)})
    for note_of_one in (modelled, unnamed):
        (ball,) = fit_eyeballs(head_template, note_of_one, still)
        assert ball.side == side
        np.testing.assert_array_equal(ball.centre, both[side].centre)


def test_lids_without_a_region_are_their_margins(head_template):
    note = head_template.annotation
    bare = replace(note, regions={name: ids for name, ids in note.regions.items() if not name.startswith("eyes_")})
    still = np.zeros((0, *head_template.vertices.shape))
    assert [ball.side for ball in fit_eyeballs(head_template, bare, still)] == ["left", "right"]
    assert np.isin(lid_vertices(bare, "left"), lid_vertices(note, "left")).all()


def test_lids_in_a_socket_that_reaches_to_their_margins_are_these(head_template):
    note = head_template.annotation
    margins = np.concatenate([note.curves["eye_upper_left"], note.curves["eye_lower_left"]])
    regions = {"eye_socket_left": np.append(note.regions["eye_socket_left"], margins)}
    np.testing.assert_array_equal(lid_vertices(replace(note, regions=regions), "left"), np.unique(margins))


def test_a_mesh_that_the_annotation_does_not_fit_has_no_eyes(head_template):
    coarse = Mesh(head_template.vertices, head_template.faces[:50])
    assert fit_eyeballs(coarse, head_template.annotation, np.zeros((1, 4200, 3))) == []
