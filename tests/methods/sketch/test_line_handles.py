import numpy as np
import pytest

from caricli.geometry.lines.match_line import resample
from caricli.methods.sketch.line_handles import lines_by_curve
from caricli.structures.sketch import Sketch, Stroke
from tests.named_lines import points_by_curve


@pytest.fixture(scope="module")
def own(person, handles, camera):
    return camera.project(person[handles.vertices])


def test_lines_of_the_curves_want_the_handles_where_they_are(sketch, handles, own):
    places = handles.places(lines_by_curve(sketch), own)
    gaps = np.linalg.norm(places - own, axis=1)
    assert np.nanmean(gaps) < 0.3 and np.nanmax(gaps) < 2.5
    assert np.isfinite(places).all(axis=1).mean() > 0.98


def test_the_direction_of_a_stroke_does_not_count(sketch, handles, own):
    backwards = sketch.with_strokes(stroke.moved(stroke.points[::-1]) for stroke in sketch.strokes)
    places = [handles.places(lines_by_curve(each), own) for each in (sketch, backwards)]
    assert np.nanmedian(np.linalg.norm(places[0] - places[1], axis=1)) < 0.3
    assert np.nanmax(np.linalg.norm(places[0] - places[1], axis=1)) < 2


def test_a_curve_in_two_strokes_keeps_its_gap(sketch, handles, own):
    """Half of the lower lip is drawn from the left, half from the right, and the middle not at all."""
    line = points_by_curve(sketch)["mouth_lower"]
    count = len(line)
    places = handles.places({"mouth_lower": [line[: count // 2 - 1], line[count // 2 + 2 :][::-1]]}, own)
    rows = handles.rows["mouth_lower"]
    met = np.isfinite(places[rows]).all(axis=1)
    assert met[[0, -1]].all() and not met.all() and met.sum() >= count - 5
    np.testing.assert_allclose(places[rows][met], line[met], atol=1.5)
    assert np.isnan(np.delete(places, rows, axis=0)).all()


def test_a_stroke_over_another_counts_half(sketch, handles, own):
    line = points_by_curve(sketch)["brow_left"]
    places = handles.places({"brow_left": [line, line + [0, 4]]}, own)
    np.testing.assert_allclose(places[handles.rows["brow_left"]][1:-1], (line + [0, 2])[1:-1], atol=1.5)


def test_a_closed_stroke_that_comes_twice_counts_once(sketch, handles, own):
    ring = points_by_curve(sketch)["silhouette"]
    once, twice = (handles.places({"silhouette": [ring] * count}, own) for count in (1, 2))
    np.testing.assert_allclose(once, twice)


@pytest.mark.parametrize("shift", [0, 20])
def test_a_closed_curve_may_begin_anywhere(sketch, handles, own, shift):
    ring = points_by_curve(sketch)["silhouette"][:-1]
    turned = np.roll(ring, shift, axis=0)
    places = handles.places({"silhouette": [np.concatenate([turned, turned[:1]])]}, own)
    gaps = np.linalg.norm(places - own, axis=1)[handles.rows["silhouette"]]
    assert gaps.max() < 4 and gaps.mean() < 1


@pytest.mark.parametrize("over", [0, 5])
def test_an_outline_is_the_same_in_both_directions(sketch, handles, own, over):
    """Also where a hand goes on beyond its beginning, and does not meet it."""
    ring = points_by_curve(sketch)["silhouette"]
    bent = ring + 3 * np.sin(np.arange(len(ring)))[:, None]
    line = np.concatenate([bent, bent[1 : 1 + over] + [2, -2]])
    there, back = (handles.places({"silhouette": [each]}, own) for each in (line, line[::-1]))
    np.testing.assert_allclose(there, back, atol=1e-6)
    moved = handles.places({"silhouette": [line + 1e-9 * np.sin(7 * np.arange(len(line)))[:, None]]}, own)
    np.testing.assert_allclose(there, moved, atol=1e-6)


def test_part_of_a_jaw_is_part_of_the_silhouette(sketch, handles, own):
    """The curve begins at the chin."""
    ring = points_by_curve(sketch)["silhouette"][:-1]
    jaw = np.r_[-12:0, 0:13]
    places = handles.places({"silhouette": [ring[jaw]]}, own)
    rows = handles.rows["silhouette"][:-1]
    met = np.isfinite(places[rows]).all(axis=1)
    assert met[jaw].mean() > 0.9 and met.sum() <= len(jaw) + 1
    assert np.nanmean(np.linalg.norm(places - own, axis=1)) < 1


def test_a_polyline_of_landmarks_is_met_at_its_points(handles, own, model):
    """The jaw's are not at equal distances here, and the vertices lie elsewhere along the line."""
    landmarks = model.template.annotation.landmarks
    rows = np.searchsorted(handles.vertices, landmarks[:17])
    line = own[rows] + np.random.default_rng(0).normal(0, 2, (17, 2))
    for drawn in (line, line[::-1]):
        np.testing.assert_allclose(handles.places({"silhouette": [drawn]}, own)[rows], line)


def test_landmarks_of_a_jaw_alone_stand_at_equal_distances(handles, own, model):
    rows = np.searchsorted(handles.vertices, model.template.annotation.landmarks[:17])
    jaw = own[handles.rows["silhouette"]][np.r_[49:66, 0:18]]
    places = handles.places({"silhouette": [1.2 * jaw]}, own)[rows]
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert np.ptp(steps) < 0.1 * steps.mean()
    np.testing.assert_allclose(places[[0, -1]], 1.2 * jaw[[0, -1]])


@pytest.mark.parametrize("bend", [0.0, 8.0])
def test_landmarks_of_lips_of_another_shape_stand_at_equal_distances(handles, own, bend):
    """A line of the own shape is met where it was, as far as it may be moved and scaled."""
    curve = next(curve for curve in handles.curves if curve.name == "mouth_lower")
    rows = handles.rows[curve.name]
    lip = own[rows]
    share = (lip[:, :1] - lip[0, 0]) / (lip[-1, 0] - lip[0, 0])
    drawn = 1.3 * lip + bend * np.sin(2 * np.pi * share) * [0, 1]
    places = handles.places({curve.name: [resample(drawn, 60)]}, own)[rows]
    np.testing.assert_allclose(places[[0, -1]], drawn[[0, -1]])
    if bend:
        steps = np.linalg.norm(np.diff(places[curve.marks], axis=0), axis=1)
        assert np.ptp(steps) < 0.1 * steps.mean()
    else:
        assert np.abs(places - drawn).max() < 2


def test_a_curve_through_landmarks_is_met_at_them(handles, own, model):
    """As drawing programs have it: as many points between any two of them."""
    rows = np.searchsorted(handles.vertices, model.template.annotation.landmarks[48:55])
    lip = own[rows] + np.random.default_rng(0).normal(0, 2, (7, 2))
    line = np.vstack([resample(lip[k : k + 2], 6)[:-1] for k in range(6)] + [lip[-1:]])
    np.testing.assert_allclose(handles.places({"mouth_upper": [line]}, own)[rows], lip)


def test_dots_are_no_lines():
    sketch = Sketch((Stroke(np.full((3, 2), 9.0), curve="nose"), Stroke(np.array([[1.0, 1], [9, 9]]), curve="nose")))
    assert [len(line) for line in lines_by_curve(sketch)["nose"]] == [2]


def test_handles_are_found_by_how_their_curves_begin(handles):
    both = np.union1d(handles.rows["brow_left"], handles.rows["brow_right"])
    np.testing.assert_array_equal(handles.rows_of("brow_"), both)
    np.testing.assert_array_equal(handles.rows_of("brow_left"), np.unique(handles.rows["brow_left"]))
    assert handles.rows_of("hat").shape == (0,)
