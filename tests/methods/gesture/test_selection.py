import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.lines.line_distances import line_distances
from caricli.methods.gesture.selection import (
    Selection,
    inside_ring,
    mark_handles,
    select_region,
)
from tests.methods.gesture.conftest import mark, ring, view


def test_the_brush_marks_what_is_seen_below_it(face, head_template):
    camera = view()
    line = np.stack([mark(face, head_template, camera, number) for number in range(17, 22)])
    handles = mark_handles(face, camera, line, 6, Selection()).handles
    assert set(head_template.annotation.landmarks[17:22]) <= set(handles.tolist())
    assert line_distances(camera.project(face.vertices[handles]), [line]).max() <= 6
    assert (face.vertices[handles, 2] > np.median(face.vertices[:, 2])).all()  # nothing of the back of the head


def test_what_is_brushed_out_is_no_handle_any_more(face, head_template):
    camera = view()
    nose = mark(face, head_template, camera, 30)[None]
    both = mark_handles(face, camera, nose, 20, Selection())
    less = mark_handles(face, camera, nose, 10, both, erase=True)
    assert 0 < len(less.handles) < len(both.handles) and set(less.handles) < set(both.handles)


def test_a_brush_beside_the_head_is_refused(face):
    with pytest.raises(InputError, match="none of it below the brush"):
        mark_handles(face, view(), np.array([[-900.0, 0]]), 10, Selection())
    with pytest.raises(InputError, match="none of it within"):
        select_region(face, view(), ring(np.array([-900.0, 0]), 10), Selection())
    with pytest.raises(InputError, match="expected a stroke"):
        select_region(face, view(), np.zeros((2, 2)), Selection())


def test_a_region_is_what_the_stroke_goes_around_and_its_pockets(face, head_template):
    camera = view()
    centre = mark(face, head_template, camera, 62)
    selection = select_region(face, camera, ring(centre, 60, 0.7), Selection())
    regions = head_template.annotation.regions
    assert set(regions["inner_mouth"]) <= set(selection.region.tolist())
    assert len(selection.skin) < len(selection.region)
    assert set(selection.skin) <= set(selection.region)
    # The nape lies within the stroke, too, but belongs to another side.
    assert face.vertices[selection.skin, 2].min() > np.median(face.vertices[:, 2])
    nose = select_region(face, camera, ring(mark(face, head_template, camera, 30), 25), selection)
    assert not np.array_equal(nose.region, selection.region)


def test_the_mirror_image_of_a_selection(face, head_template):
    camera = view()
    eye = select_region(face, camera, ring(mark(face, head_template, camera, 37), 30), Selection())
    other = select_region(face, camera, ring(mark(face, head_template, camera, 44), 30), Selection())
    both = eye.with_other(eye.mirrored(head_template))
    shared = np.intersect1d(eye.mirrored(head_template).region, other.region)
    assert len(shared) > 0.9 * len(other.region)
    assert len(both.region) == 2 * len(eye.region)


def test_points_in_rings_and_distances_as_by_hand():
    square = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]])
    points = np.array([[1.0, 1], [3, 1], [1, -0.1], [1.9, 0.1]])
    assert inside_ring(points, square).tolist() == [True, False, False, True]
    assert inside_ring(points, square[::-1]).tolist() == [True, False, False, True]
    np.testing.assert_allclose(line_distances(points, [square[:2]]), [1, np.sqrt(2), 0.1, 0.1])
