from dataclasses import replace

import igl
import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.flattening.triangle_stretch import triangle_stretch
from caricli.structures.landmarks import LIPS_INSIDE
from caricli.template.chart import face_chart


@pytest.fixture(scope="module")
def chart(head_template):
    return face_chart(head_template)


def areas(chart):
    corners = chart.uvs[chart.faces]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2


def annotated(template, **changes):
    return replace(template, annotation=replace(template.annotation, **changes))


def test_no_triangle_is_turned_over_and_none_lies_on_another(chart):
    # The sum of the areas is that within the border: signed areas alone would hide a second layer.
    loops = [np.asarray(loop) for loop in igl.boundary_loop_all(chart.faces)]
    assert len(loops) == 5
    x, y = chart.uvs.T
    inside = sum((x[loop] * np.roll(y[loop], -1) - np.roll(x[loop], -1) * y[loop]).sum() / 2 for loop in loops)
    assert (areas(chart) > 0).all()
    np.testing.assert_allclose(areas(chart).sum(), inside, rtol=1e-9)


def test_it_fills_the_unit_square_upright(chart, head_template):
    assert chart.uvs.min() >= 0.02 - 1e-9 and chart.uvs.max() <= 0.98 + 1e-9
    assert areas(chart).sum() > 0.6
    place = dict(zip(chart.vertices.tolist(), chart.uvs, strict=True))
    chin, brow, right, left = (place[int(head_template.annotation.landmarks[k])] for k in (8, 27, 36, 45))
    assert brow[1] - chin[1] > 0.4 and left[0] - right[0] > 0.3


def test_it_is_its_own_mirror_image(chart, head_template):
    mirror = head_template.annotation.mirror
    other = np.searchsorted(chart.vertices, mirror[chart.vertices])
    np.testing.assert_array_equal(chart.vertices[other], mirror[chart.vertices])
    np.testing.assert_allclose(chart.uvs[other], chart.uvs * [-1, 1] + [1, 0], atol=1e-12)


def test_the_membrane_closes_what_is_between_the_inner_lips(chart, head_template):
    lips = np.unique(chart.corners[chart.membrane])
    curves = head_template.annotation.curves
    np.testing.assert_array_equal(lips, np.union1d(curves["mouth_inner_upper"], curves["mouth_inner_lower"]))
    assert np.isin(head_template.annotation.landmarks[LIPS_INSIDE], lips).all()
    assert chart.membrane.sum() == len(lips) - 2
    assert (chart.triangles[chart.membrane] == -1).all()
    skin = ~chart.membrane
    np.testing.assert_array_equal(chart.corners[skin], head_template.faces[chart.triangles[skin]])
    assert areas(chart)[chart.membrane].sum() > 0.01


def test_it_is_as_rigid_as_the_size_of_the_mouth_lets_it_be(chart, head_template):
    skin = ~chart.membrane
    stretch = triangle_stretch(head_template.vertices, chart.corners[skin], chart.uvs, chart.faces[skin])
    assert np.median(stretch[:, 0] / stretch[:, 1]) < 1.35
    assert np.quantile(stretch[:, 0] / stretch[:, 1], 0.9) < 1.7


def test_the_shape_of_the_open_head_does_not_matter(chart, head_template):
    other = face_chart(head_template.with_vertices(1.3 * head_template.vertices + [0, 0, 0.1]))
    np.testing.assert_array_equal(other.uvs, chart.uvs)


def test_a_chart_that_was_kept_is_not_taken_for_that_of_other_ears(chart, head_template):
    regions = {name: ids for name, ids in head_template.annotation.regions.items() if not name.startswith("ear")}
    assert len(face_chart(annotated(head_template, regions=regions)).vertices) > len(chart.vertices)


def test_a_head_in_another_order_without_a_mirror(chart, head_template):
    order = np.random.default_rng(3).permutation(len(head_template.vertices))
    place = np.argsort(order)
    note = head_template.annotation
    regions = {name: place[ids] for name, ids in note.regions.items()}
    shuffled = replace(
        head_template,
        vertices=head_template.vertices[order],
        polygons=place[head_template.polygons].astype(np.int32),
        annotation=replace(note, landmarks=place[note.landmarks], regions=regions, mirror=None),
    )
    other = face_chart(shuffled)
    assert (areas(other) > 0).all() and other.membrane.sum() == chart.membrane.sum()
    ids = order[other.vertices]
    np.testing.assert_allclose(other.uvs[np.argsort(ids)], chart.uvs[np.argsort(chart.vertices)], atol=0.01)


def test_a_face_without_an_opening_has_no_membrane(ball):
    from caricli.template.annotation import parse_annotation
    from caricli.template.template import Template

    vertices, faces = ball
    front = np.flatnonzero(vertices[:, 2] > 0.1).tolist()
    nose = int(vertices[:, 2].argmax())
    others = [vertex for vertex in front if vertex != nose]
    landmarks = [*others[:30], nose, *others[30:67]]
    note = parse_annotation({"ibug68": landmarks, "regions": {"face": front}}, len(vertices), "ball")
    chart = face_chart(Template(vertices, faces, annotation=note))
    assert not chart.membrane.any() and (areas(chart) > 0).all()


@pytest.mark.parametrize(
    ("regions", "problem"),
    [
        ({}, "needs 'regions.face', its vertices"),
        ({"face": [0, 1, 2]}, "around the tip of the nose"),
        ({"face": [0, 1, 2], "inner_mouth": [0, 1, 2], "ear_left": [3]}, "around the tip of the nose"),
    ],
)
def test_an_annotation_without_a_face(head_template, regions, problem):
    with pytest.raises(InputError, match=problem):
        face_chart(annotated(head_template, regions=regions))


def test_a_face_that_is_all_of_the_surface(ball):
    from caricli.template.annotation import parse_annotation
    from caricli.template.template import Template

    vertices, faces = ball
    everywhere = list(range(len(vertices)))
    note = parse_annotation({"ibug68": everywhere[:68], "regions": {"face": everywhere}}, len(vertices), "ball")
    with pytest.raises(InputError, match="one sheet with holes"):
        face_chart(Template(vertices, faces, annotation=note))
