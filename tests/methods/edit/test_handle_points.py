import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.edit.handle_points import displacement_of, handle_points, vertex_of
from caricli.structures.landmarks import POINT_NAMES


def test_places_are_vertices_landmarks_or_names(head_template):
    landmarks = head_template.annotation.landmarks
    assert vertex_of("17", head_template) == 17
    assert vertex_of("l30", head_template) == vertex_of("nose_tip", head_template) == landmarks[30]
    for name, number in POINT_NAMES.items():
        assert vertex_of(name, head_template) == landmarks[number]


def test_left_is_the_subject_s(head_template):
    x = head_template.vertices[:, 0]
    for name in POINT_NAMES:
        if "left" in name:
            assert x[vertex_of(name, head_template)] > 0 > x[vertex_of(name.replace("left", "right"), head_template)]


@pytest.mark.parametrize("where", ["4200", "-1", "l81", "lx", "", "²", "1.5"])
def test_other_places_are_refused(head_template, where):
    with pytest.raises(InputError, match="handle"):
        vertex_of(where, head_template)


def test_the_nearest_name_is_suggested(head_template):
    with pytest.raises(InputError, match="did you mean cheekbone_left"):
        vertex_of("cheekbone_lef", head_template)


def test_lengths_are_metres_or_shares():
    assert displacement_of(["0.01", "-5%", 0], 0.24, "x") == pytest.approx([0.01, -0.012, 0])


@pytest.mark.parametrize(
    "values", [["1", "2"], "abc", ["nan", 0, 0], ["inf", 0, 0], ["60%", 0, 0], ["a", 0, 0], [None] * 3]
)
def test_other_lengths_are_refused(values):
    with pytest.raises(InputError, match="handle x"):
        displacement_of(values, 0.24, "x")


def test_symmetric_handles_come_in_pairs(head_template):
    handles = handle_points([("ear_left", [0.01, 0.02, 0])], ["chin"], head_template, symmetric=True)
    assert handles.vertices.tolist() == [vertex_of(name, head_template) for name in ("ear_left", "ear_right", "chin")]
    assert handles.displacements.tolist() == [[0.01, 0.02, 0], [-0.01, 0.02, 0], [0, 0, 0]]
    assert handles.names == ("ear_left", "ear_left mirrored", "chin")
    assert handles.scaled(0.5).displacements.tolist() == [[0.005, 0.01, 0], [-0.005, 0.01, 0], [0, 0, 0]]


def test_shares_are_of_the_height_of_the_face_that_is_edited(head_template):
    large = head_template.with_vertices(1.2 * head_template.vertices)
    moved, further = (handle_points([("chin", [0, "-5%", 0.001])], [], head) for head in (head_template, large))
    height = np.ptp(head_template.vertices[:, 1])
    np.testing.assert_allclose(moved.displacements, [[0, -0.05 * height, 0.001]])
    np.testing.assert_allclose(further.displacements, [[0, -0.06 * height, 0.001]])
    # So is the most that a handle may move.
    far = [("chin", [0, 0.55 * height, 0])]
    assert len(handle_points(far, [], large).vertices) == 1
    with pytest.raises(InputError, match="half the head's height"):
        handle_points(far, [], head_template)


def test_contradictions_are_refused(head_template):
    for asked, pins, symmetric in (
        ([("nose_tip", [0, 0, 0.01]), ("l30", [0, 0, 0.02])], [], False),
        ([("nose_tip", [0, 0, 0.01])], ["l30"], False),
        ([("nose_tip", [0.01, 0, 0])], [], True),
    ):
        with pytest.raises(InputError, match="contradict"):
            handle_points(asked, pins, head_template, symmetric)
    assert len(handle_points([("nose_tip", [0, 0, 0.01])] * 2, [], head_template, True).vertices) == 1


@pytest.mark.parametrize("asked", [[], [("nose_tip", [0, 0, 0])]])
def test_something_must_move(head_template, asked):
    with pytest.raises(InputError, match="handle that moves"):
        handle_points(asked, ["chin"], head_template)
