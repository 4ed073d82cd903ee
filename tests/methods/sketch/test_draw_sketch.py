import numpy as np

from caricli.methods.sketch.draw_sketch import FILL, canvas_camera, draw_sketch
from caricli.template.feature_curves import feature_curves
from tests.named_lines import points_by_curve


def test_strokes_are_the_projected_curves(head_template):
    curves = feature_curves(head_template.annotation)
    camera = canvas_camera(head_template.vertices, curves)
    sketch = draw_sketch(head_template.vertices, curves, camera)
    named = points_by_curve(sketch)
    assert list(named) == [curve.name for curve in curves]
    for curve in curves:
        assert np.allclose(named[curve.name], camera.project(head_template.vertices[curve.vertices]))


def test_the_head_fills_the_middle_of_the_canvas(head_template):
    curves = feature_curves(head_template.annotation)
    for view in ((0.0, 0.0), (30.0, -10.0)):
        camera = canvas_camera(head_template.vertices, curves, view, 100)
        points = np.concatenate([s.points for s in draw_sketch(head_template.vertices, curves, camera).strokes])
        assert np.isclose(np.ptp(points, axis=0).max(), FILL * 100)
        assert np.allclose((points.min(0) + points.max(0)) / 2, 49.5)


def test_a_positive_yaw_looks_to_the_right_and_a_positive_pitch_down(head_template):
    curves = feature_curves(head_template.annotation)

    def place(view):
        camera = canvas_camera(head_template.vertices, curves, view)
        named = points_by_curve(draw_sketch(head_template.vertices, curves, camera))
        return named["nose_tip"].mean(0) - np.mean([named["ear_left"].mean(0), named["ear_right"].mean(0)], axis=0)

    assert abs(place((0, 0))[0]) < 1 and place((20, 0))[0] > 10
    assert place((0, 15))[1] > place((0, 0))[1] + 5
