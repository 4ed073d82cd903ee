from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError, NumericsError
from caricli.methods.marks.lay_mean_shape import lay_mean_shape, middle_frame
from caricli.methods.marks.mirror_map import mirror_map
from caricli.methods.marks.move_marks import FACE, GroupMove, move_group, move_point, switch_off
from caricli.structures import Landmarks
from caricli.structures.detection import FaceFrame, turn_axes
from caricli.structures.landmarks import GROUPS, MIRRORED, POINT_NAMES, group_of, point_label

SIZE = (400, 300)


@pytest.fixture(scope="module")
def template(head_template):
    return head_template


@pytest.fixture
def marks(template):
    return lay_mean_shape(template, middle_frame(SIZE), SIZE)


def sure(marks):
    return replace(
        marks, spreads=np.tile(4 * np.eye(2), (81, 1, 1)), visibility=np.full(81, 0.5), slides=np.ones((81, 2))
    )


def test_every_point_has_one_group_and_a_name_of_its_own():
    assert sorted(k for numbers in GROUPS.values() for k in numbers) == list(range(81))
    labels = [point_label(k) for k in range(81)]
    assert len(set(labels)) == 81
    assert labels[30] == "nose tip" and labels[37] == "right eye 2 of 6" and group_of(37) == "eye_right"


def test_the_mean_shape_fills_the_frame_it_is_laid_into(template):
    frame = FaceFrame(np.array([210.0, 140.0]), 180.0, 0.3)
    marks = lay_mean_shape(template, frame, SIZE)
    own = FaceFrame.of(marks.points)
    assert np.allclose(own.centre, frame.centre) and own.side == pytest.approx(180) and own.roll == pytest.approx(0.3)
    assert marks.known.all() and marks.image_size == SIZE
    upright = lay_mean_shape(template, middle_frame(SIZE), SIZE).points
    assert upright[30, 1] > upright[27, 1] and upright[36, 0] < upright[45, 0]
    with pytest.raises(InputError, match="expected the landmarks of a face in the 400 x 300 image"):
        lay_mean_shape(template, FaceFrame(np.array([900.0, 140.0]), 180.0, 0.0), SIZE)


@pytest.mark.parametrize("roll", [0.0, 20.0, -35.0])
def test_moves_are_mirrored_at_the_axis_of_a_leaning_face(seen, template, roll):
    points = seen(template.vertices, roll=roll, count=81).points
    axes = turn_axes(np.radians(roll))
    expected = axes.T @ np.diag([-1, 1]) @ axes
    assert np.allclose(mirror_map(points, template), expected, atol=1e-6)


def test_moves_on_a_turned_face_are_what_its_picture_shows(seen, template):
    """A mesh that is widened at both eyes moves its landmarks as a point and its partner are moved."""
    camera = seen(template.vertices, yaw=25, pitch=8, roll=10, count=81).camera
    note = template.annotation.landmarks
    wide = template.vertices[note].copy()
    wide[36] += [-0.004, 0.002, 0]
    wide[45] += [0.004, 0.002, 0]
    before = camera.project(template.vertices[note])
    truth = camera.project(wide)
    moved = move_point(Landmarks(before), 36, tuple(truth[36]), template)
    assert np.allclose(moved.points, truth, atol=1e-6)


def test_the_map_is_its_own_inverse_and_knows_no_jaw(seen, template):
    points = seen(template.vertices, yaw=-30, pitch=10, count=81).points
    mirror = mirror_map(points, template)
    assert np.allclose(mirror @ mirror, np.eye(2))
    dragged = points.copy()
    dragged[3] += 50
    assert np.allclose(mirror_map(dragged, template), mirror)
    few = np.full_like(points, np.nan)
    few[:10] = points[:10]
    assert np.isfinite(mirror_map(few, template)).all()
    with pytest.raises(NumericsError):
        mirror_map(np.full((81, 2), 5.0), template)
    # Nearly from the side a small move here would be a large one there.
    with pytest.raises(NumericsError, match="seen from the side"):
        mirror_map(seen(template.vertices, yaw=85, pitch=10, count=81).points, template)


def test_a_point_moves_alone_or_with_its_partner(marks, template):
    moved = move_point(marks, 48, (100.0, 200.0))
    assert (moved.points[48] == [100, 200]).all() and np.array_equal(
        np.delete(moved.points, 48, 0), np.delete(marks.points, 48, 0)
    )
    both = move_point(marks, 48, tuple(marks.points[48] + [-5, 3]), template)
    assert np.allclose(both.points[54] - marks.points[54], [5, 3], atol=0.05)
    middle = move_point(marks, 8, tuple(marks.points[8] + [2, 3]), template)
    assert ((middle.points != marks.points).any(1) == (np.arange(81) == 8)).all()
    alone = move_point(switch_off(marks, [54]), 48, (100.0, 200.0), template)
    assert not alone.known[54]
    assert marks.known.all()


def test_points_that_were_moved_are_sure_and_those_that_are_off_are_not_known(marks):
    marks = sure(marks)
    moved = move_point(marks, 48, (100.0, 200.0))
    assert np.trace(moved.spreads[48]) < 0.1 and moved.visibility[48] == 1
    assert (moved.spreads[47] == marks.spreads[47]).all() and moved.visibility[47] == 0.5
    assert not moved.slides[48].any() and (moved.head_points[48] == (100, 200)).all() and (moved.slides[47] == 1).all()
    off = switch_off(moved, [48, 60])
    assert off.known.sum() == 79 and np.isnan(off.spreads[[48, 60]]).all() and (off.visibility[[48, 60]] == 0).all()
    assert not off.slides[[48, 60]].any()
    back = move_point(off, 48, (101.0, 200.0))
    assert back.known.sum() == 80 and np.isfinite(back.spreads[48]).all()


def test_slides_go_with_what_is_not_placed_by_itself(marks, template):
    marks = sure(marks)
    still = move_group(marks, "face", GroupMove())
    np.testing.assert_allclose(still.head_points, marks.head_points, atol=1e-9)
    turned = move_group(marks, "mouth", GroupMove(turn=90, scale=2))
    np.testing.assert_allclose(turned.slides[48], [-2, 2], atol=1e-9)
    assert (turned.slides[47] == 1).all()
    both = move_point(marks, 48, tuple(marks.points[48] + [3.0, 0.0]), template)
    assert not both.slides[48].any() and (both.slides[54] == 1).all()


def test_groups_shift_turn_and_scale_about_their_centre(marks, template):
    mouth = list(GROUPS["mouth"])
    moved = move_group(marks, "mouth", GroupMove((3.0, -2.0), 30.0, 1.5))
    before = marks.points[mouth] - marks.points[mouth].mean(0)
    after = moved.points[mouth] - moved.points[mouth].mean(0)
    assert np.allclose(moved.points[mouth].mean(0) - marks.points[mouth].mean(0), [3, -2])
    assert np.linalg.norm(after) == pytest.approx(1.5 * np.linalg.norm(before))
    right, left = mouth.index(48), mouth.index(54)
    assert (after[left] - after[right])[1] > 0  # clockwise: the right end of what is seen goes down
    still = np.delete(np.arange(81), mouth)
    assert np.array_equal(moved.points[still], marks.points[still])
    whole = move_group(marks, FACE, GroupMove(scale=0.5))
    assert whole.diagonal == pytest.approx(marks.diagonal / 2)
    same = move_group(marks, "mouth", GroupMove((3.0, -2.0), 30.0, 1.5), template)
    assert np.array_equal(same.points, moved.points)


def test_a_group_of_one_side_takes_its_partner_along(marks, template):
    moved = move_group(marks, "brow_left", GroupMove((4.0, -6.0), 12.0, 1.2), template).points
    mirrored = move_group(marks, "brow_right", GroupMove((-4.0, -6.0), -12.0, 1.2)).points
    assert np.allclose(moved[list(GROUPS["brow_right"])], mirrored[list(GROUPS["brow_right"])], atol=0.05)
    alone = move_group(switch_off(marks, list(GROUPS["brow_right"])), "brow_left", GroupMove((4.0, 0.0)), template)
    assert not alone.known[list(GROUPS["brow_right"])].any()


@pytest.mark.parametrize("off", [22, 26, 21], ids=["inner end", "outer end", "end of the other side"])
def test_both_sides_make_mirrored_moves_where_a_point_is_off(seen, template, off):
    marks = switch_off(Landmarks(seen(template.vertices, yaw=15, roll=10, count=81).points), [off])
    moved = move_group(marks, "brow_left", GroupMove((4.0, -6.0), 12.0, 1.2), template)
    left = [k for k in GROUPS["brow_left"] if marks.known[k]]
    right = [k for k in GROUPS["brow_right"] if marks.known[k]]
    ways = moved.points - marks.points
    pairs = [k for k in left if marks.known[MIRRORED[k]]]
    mirror = mirror_map(marks.points, template)
    ours, theirs = (ways[each].mean(0) for each in (pairs, [MIRRORED[k] for k in pairs]))
    np.testing.assert_allclose(ours, [4, -6], atol=1e-9)
    np.testing.assert_allclose(theirs, mirror @ ours, atol=1e-9)
    # All of a side makes one move, that of which the point on the other side is off, too.
    for side in (left, right):
        places = np.column_stack([marks.points[side], np.ones(len(side))])
        rest = moved.points[side] - places @ np.linalg.lstsq(places, moved.points[side])[0]
        np.testing.assert_allclose(rest, 0, atol=1e-9)
    np.testing.assert_array_equal(np.flatnonzero(np.nan_to_num(ways).any(1)), sorted(left + right))


def test_sides_that_share_no_point_move_about_their_own_centres(marks, template):
    apart = switch_off(marks, [22, 23, 24, 17, 18])
    moved = move_group(apart, "brow_left", GroupMove((4.0, -6.0), scale=1.5), template).points - apart.points
    np.testing.assert_allclose(moved[[25, 26]].mean(0), [4, -6], atol=1e-9)
    np.testing.assert_allclose(moved[[19, 20, 21]].mean(0), [-4, -6], atol=0.05)


def test_names_and_partners_agree():
    for name, number in POINT_NAMES.items():
        other = name.replace("left", "?").replace("right", "left").replace("?", "right")
        assert POINT_NAMES[other] == MIRRORED[number]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda marks: move_point(marks, 81, (1.0, 1.0)), "point: expected a number from 0 to 80, found 81"),
        (lambda marks: move_point(marks, -1, (1.0, 1.0)), "point: expected a number from 0 to 80, found -1"),
        (lambda marks: move_point(marks, 3, (9000.0, 1.0)), "point 3: expected a place in or near the 400 x 300"),
        (lambda marks: move_group(marks, "cheek", GroupMove()), "group: expected face, jaw, .*, found cheek"),
        (lambda marks: move_group(marks, "nose", GroupMove(scale=0)), "scale: expected more than 0, found 0"),
        (lambda marks: move_group(switch_off(marks, list(GROUPS["temples"])), "temples", GroupMove()), "none"),
        (lambda marks: switch_off(marks, list(range(74))), "expected at least 8 known points, found 7"),
    ],
)
def test_what_cannot_be_is_refused(marks, change, message):
    with pytest.raises(InputError, match=message):
        change(marks)
