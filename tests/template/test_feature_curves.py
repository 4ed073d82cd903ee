from dataclasses import replace

import numpy as np

from caricli.structures import StrokeKind
from caricli.template.annotation import bundled_annotation, parse_annotation
from caricli.template.feature_curves import SILHOUETTE, feature_curves


def test_the_head_has_its_curves():
    curves = feature_curves(bundled_annotation())
    names = [curve.name for curve in curves]
    assert names[0] == SILHOUETTE and len(set(names)) == len(names) == 20
    kinds = {curve.name: curve.kind for curve in curves}
    assert kinds[SILHOUETTE] is StrokeKind.SILHOUETTE and kinds["nose"] is StrokeKind.FEATURE
    assert kinds["mouth_upper"] is StrokeKind.WRINKLE
    assert {curve.name for curve in curves if curve.closed} == {SILHOUETTE, "nostril_left", "nostril_right"}


def test_curves_run_along_edges_and_sides_mirror_each_other(head_template):
    mirror = bundled_annotation().mirror
    polygons = head_template.polygons
    edges = {frozenset(e) for k in range(4) for e in zip(polygons[:, k], polygons[:, (k + 1) % 4], strict=True)}
    curves = {curve.name: curve for curve in feature_curves(bundled_annotation())}
    for name in ("eye_fold_left", "nostril_left", SILHOUETTE):
        ids = curves[name].vertices
        assert all(frozenset(edge) in edges for edge in zip(ids[:-1], ids[1:], strict=True)), name
    for name in ("eye_fold", "nostril", "ear", "brow"):
        left = curves[f"{name}_left"].vertices
        assert np.array_equal(mirror[left], curves[f"{name}_right"].vertices)


def test_the_fold_lies_above_the_lid(head_template):
    vertices = head_template.vertices
    curves = {curve.name: vertices[curve.vertices] for curve in feature_curves(bundled_annotation())}
    lid = curves["eye_upper_left"][1:-1, 1]
    assert (curves["eye_fold_left"][:, 1] > lid).all()


def test_an_older_annotation_of_the_head_is_completed():
    bundled = bundled_annotation()
    older = replace(bundled, curves={name: ids for name, ids in bundled.curves.items() if "nostril" not in name})
    assert [curve.name for curve in feature_curves(older)] == [curve.name for curve in feature_curves(bundled)]


def test_another_head_has_the_curves_that_it_names():
    value = {"ibug68": [*range(68)], "curves": {"scar": [1, 2], "silhouette": [3, 4, 5], "dot": [1]}}
    curves = feature_curves(parse_annotation(value | {"closed_curves": ["silhouette"]}, 68, "a.json"))
    assert [curve.name for curve in curves] == ["silhouette", "scar"]
    assert curves[0].vertices.tolist() == [3, 4, 5, 3]


def test_the_landmark_where_a_closed_curve_begins_and_ends_stands_on_it_once():
    value = {"ibug68": [*range(68)], "curves": {"silhouette": [3, 70, 4, 71, 72, 5, 3]}}
    (curve,) = feature_curves(parse_annotation(value, 80, "a.json"))
    assert curve.closed and curve.marks.tolist() == [5, 0, 2]


def test_landmarks_stand_on_the_curves_in_their_order():
    note = bundled_annotation()
    curves = {curve.name: curve for curve in feature_curves(note)}
    assert note.landmarks[:17].tolist() == curves["silhouette"].vertices[curves["silhouette"].marks].tolist()
    for name, numbers in {"nose": range(31, 36), "eye_upper_left": range(42, 46), "nose_tip": ()}.items():
        assert set(curves[name].vertices[curves[name].marks]) == set(note.landmarks[list(numbers)])
