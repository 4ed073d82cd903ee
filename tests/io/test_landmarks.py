import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from caricli.errors import InputError, OutputError
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.structures import Landmarks

NAN = float("nan")


def circle(count=68):
    angles = np.linspace(0, 6, count)
    return np.stack([100 + 50 * np.cos(angles), 120 + 50 * np.sin(angles)], axis=1)


def as_json(given, **changes):
    entries = [None if np.isnan(point).any() else list(point) for point in given]
    value = {"schema": "caricli.landmarks/1", "scheme": "ibug68", "image": {"width": 200, "height": 300}}
    return json.dumps({**value, "points": entries, **changes})


def as_text(points):
    return "".join(f"{x} {y}\n" for x, y in points)


def read(folder, content, name="a.txt", **options):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_landmarks(path, **options)


COORDINATE = st.floats(-999_000, 999_000)
POINT = st.tuples(COORDINATE, COORDINATE) | st.just((NAN, NAN))
KNOWN = st.just([(0.0, 0.0), (100.0, 50.0)] * 5)
POINTS = st.one_of(
    *(st.tuples(KNOWN, st.lists(POINT, min_size=n - 10, max_size=n - 10)).map(lambda p: p[0] + p[1]) for n in (68, 81))
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(points=POINTS, suffix=st.sampled_from([".json", ".txt", ".npy", ".pts"]))
def test_round_trip(tmp_path_factory, points, suffix):
    path = tmp_path_factory.mktemp("landmarks") / f"a{suffix}"
    points = np.array(points)
    write_landmarks(path, Landmarks(points))
    back = read_landmarks(path)
    assert back.image_size is None
    # One is added and subtracted again in .pts files.
    np.testing.assert_allclose(back.points, points, rtol=0, atol=1e-9 if suffix == ".pts" else 0)
    copy = path.with_suffix(".other" if suffix != ".pts" else ".pts")
    path.rename(copy)
    np.testing.assert_array_equal(read_landmarks(copy).points, back.points)


def test_json_keeps_the_image_size(tmp_path):
    points = circle()
    points[3] = NAN
    write_landmarks(tmp_path / "a.json", Landmarks(points, (200, 300)))
    assert json.loads((tmp_path / "a.json").read_text()) == json.loads(as_json(points))
    back = read_landmarks(tmp_path / "a.json")
    assert back.image_size == (200, 300)
    np.testing.assert_array_equal(back.points, points)
    write_landmarks(tmp_path / "b.json", Landmarks(circle(81), (200, 300)))
    assert json.loads((tmp_path / "b.json").read_text())["scheme"] == "ibug68+13"


def test_pts_counts_from_its_origin(tmp_path):
    content = "version: 1\r\nn_points:  68\r\n{\r\n" + as_text(circle()).replace("\n", "\r\n") + "}\r\n"
    np.testing.assert_allclose(read(tmp_path, content, "a.pts").points, circle() - 1)
    np.testing.assert_allclose(read(tmp_path, content, "a.pts", pts_origin=0).points, circle())
    np.testing.assert_allclose(read(tmp_path, content, "a.txt").points, circle() - 1)
    np.testing.assert_allclose(read(tmp_path, as_text(circle())).points, circle())


@pytest.mark.parametrize(
    "content",
    [
        as_text(circle()).replace(" ", ", "),
        as_text(circle()).replace(" ", "\t").replace("\n", "\r\n"),
        "\ufeff\n" + as_text(circle()) + "\n\n",
        as_json(circle()),
        as_json(circle(), image=None),
        " " + as_json(circle()),
    ],
)
def test_spellings(tmp_path, content):
    np.testing.assert_allclose(read(tmp_path, content).points, circle())


def test_unknown_points(tmp_path):
    lines = as_text(circle()).splitlines()
    lines[0], lines[1] = "null", "null null"
    points = read(tmp_path, "\n".join(lines)).points
    assert np.isnan(points[:2]).all() and np.isfinite(points[2:]).all()


def with_point(k, value, count=68):
    points = circle(count).tolist()
    points[k] = value
    return points


JSON_CASES = [
    (as_json(circle(67)), "expected 68 or 81 points, found 67"),
    (as_json(circle(69)), "expected 68 or 81 points, found 69"),
    (as_json(circle(81)), r"expected the scheme 'ibug68\+13' for 81 points, found 'ibug68'"),
    (as_json(circle(), schema="other/1"), "expected the schema 'caricli.landmarks/1', found 'other/1'"),
    (as_json(circle(), scheme="wflw"), "expected the scheme 'ibug68' for 68 points, found 'wflw'"),
    (as_json(circle(), extra=1), "found 'extra'"),
    (as_json(circle(), points={}), "expected points to be a list"),
    (as_json(circle(), points=with_point(5, [1])), r"point 5: expected \[x, y\] or null, found \[1\]"),
    (as_json(circle(), points=with_point(5, ["1", 2])), "point 5: expected"),
    (as_json(circle(), points=with_point(5, [True, 2])), "point 5: expected"),
    (as_json(circle(), points=with_point(5, [None, 2])), "point 5: expected"),
    (as_json(circle(), points=with_point(5, [1e300, 2])), "point 5: expected"),
    (as_json(circle(), points=with_point(5, [10**30, 2])), "point 5: expected"),
    (as_json(circle(), points=with_point(5, [NAN, 2])), "found NaN"),
    (as_json(circle(), points=with_point(5, [-201, 100])), "point 5: expected a place in or near the 200 x 300 image"),
    (as_json(circle(), points=with_point(5, [100, 601])), "point 5: expected a place in or near"),
    (as_json(circle() * 0 + 7), "all of them in one place"),
    (as_json(circle(), points=[[0, 0], [9, 9]] + [None] * 66), "at least 8 known points, found 2"),
    (as_json(circle(), points=[None] * 68), "at least 8 known points, found 0"),
    (as_json(circle(), image={"width": 0, "height": 5}), "expected an image size in whole pixels"),
    (as_json(circle(), image={"width": 5.5, "height": 5}), "expected an image size in whole pixels"),
    (as_json(circle(), image={"width": True, "height": 5}), "expected an image size in whole pixels"),
    (as_json(circle(), image={"width": 5}), "expected an image with width and height"),
    (as_json(circle(), image=[200, 300]), "expected an image with width and height"),
    ("[]", "found a list"),
    (as_json(circle(), schema=None), "expected the schema 'caricli.landmarks/1', found none"),
    ("{}", "expected the schema"),
    ('{"schema": 1, "schema": 2}', "twice"),
]
TEXT_CASES = [
    (as_text(circle(67)), "expected 68 or 81 points, found 67"),
    (as_text(circle(69)), "expected 68 or 81 points, found 69"),
    (as_text(circle() * 0 + 7), "all of them in one place"),
    (as_text(with_point(2, [NAN, NAN])), "line 3: expected two numbers x y, found 'nan nan'"),
    (as_text(with_point(2, [float("inf"), 1])), "line 3: expected two numbers"),
    (as_text(with_point(2, [1e308, 1])), "line 3: expected two numbers"),
    (as_text(circle()) + "1 2 3\n", "line 69: expected two numbers x y, found '1 2 3'"),
    (as_text(circle()) + "1\n", "line 69: expected two numbers"),
    ("v 1 2 3\n", "line 1: expected two numbers"),
    ("\n", "found 0"),
    ("null\n" * 68, "at least 8 known points, found 0"),
    ("1 2 \u2028 3\n", "line 2: expected two numbers"),
]
PTS = "version: 1\nn_points: 68\n{\n"
PTS_CASES = [
    (as_text(circle()), "expected 'version: 1'"),
    ("version: 2\n" + PTS[11:] + as_text(circle()) + "}", "expected 'version: 1'"),
    (PTS + as_text(circle()), "expected points between"),
    (PTS + as_text(circle(67)) + "}", "expected 'n_points: 68', found 67 points"),
    (PTS.replace("68", "67") + as_text(circle(67)) + "}", "expected 68 or 81 points, found 67"),
    (PTS + as_text(with_point(2, [NAN, NAN])) + "}", "line 6: expected two numbers"),
    (PTS, "expected 'version: 1'"),
]


@pytest.mark.parametrize(("content", "message"), JSON_CASES + TEXT_CASES)
def test_malformed(tmp_path, content, message):
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, content, "a.dat")
    assert "a.dat" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(("content", "message"), PTS_CASES)
def test_malformed_pts(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, content, "a.pts")


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (circle(67), "expected 68 or 81 points, found 67"),
        (circle().T, r"expected numbers \(L,2\), found float64 \(2, 68\)"),
        (np.zeros((68, 3)), r"expected numbers \(L,2\)"),
        (np.array(with_point(4, [1, np.inf])), "point 4: expected finite coordinates"),
        (np.array(with_point(4, [1, NAN])), "point 4: expected finite coordinates"),
        (np.full((68, 2), NAN), "at least 8 known points"),
        (np.full((68, 2), 3), "all of them in one place"),
        (np.full((68, 2), "a"), "expected numbers"),
        (np.full((68, 2), None), "Python objects, which are never loaded"),
    ],
)
def test_malformed_npy(tmp_path, array, message):
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    with pytest.raises(InputError, match=message):
        read_landmarks(tmp_path / "a.npy")


def test_points_near_the_image_are_accepted(tmp_path):
    points = read(tmp_path, as_json(circle(), points=with_point(5, [-200, 600]))).points
    assert points[5].tolist() == [-200, 600]


def test_writing_refuses(tmp_path):
    with pytest.raises(OutputError, match=r"expected \.json, \.pts, \.txt or \.npy for landmarks, found '\.xml'"):
        write_landmarks(tmp_path / "a.xml", Landmarks(circle()))
    assert list(tmp_path.iterdir()) == []


def test_spreads_visibility_and_slides_come_back(tmp_path):
    generator = np.random.default_rng(0)
    roots = generator.normal(size=(81, 2, 2))
    spreads = roots @ roots.swapaxes(1, 2) + np.eye(2)
    points = generator.uniform(0, 100, (81, 2))
    points[7] = np.nan
    spreads[7] = np.nan
    marks = Landmarks(points, (100, 100), (spreads + spreads.swapaxes(1, 2)) / 2, generator.uniform(size=81))
    marks = replace(marks, slides=generator.normal(size=(81, 2)))
    write_landmarks(tmp_path / "marks.json", marks)
    again = read_landmarks(tmp_path / "marks.json")
    np.testing.assert_array_equal(again.spreads, marks.spreads)
    np.testing.assert_array_equal(again.visibility, marks.visibility)
    np.testing.assert_array_equal(again.slides, marks.slides)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("spreads", [[1, 0, 1]] * 3, "expected a list of 68 spreads"),
        ("spreads", [[1, 2, 1]] * 68, "point 0: expected a covariance"),
        ("spreads", [None] * 68, "spread 0: expected"),
        ("spreads", [[1, 0, "1"]] * 68, "spread 0: expected"),
        ("visibility", [0.5] * 67, "expected a visibility from 0 to 1 of every point"),
        ("visibility", [2] * 68, "expected a visibility from 0 to 1 of every point"),
        ("visibility", "all", "expected visibility to be a list of numbers"),
        ("slides", [[0, 1]] * 67, "expected a list of 68 slides"),
        ("slides", {"0": [0, 1]}, "expected a list of 68 slides"),
        ("slides", [[0, 1]] * 67 + [None], r"slide 67: expected \[x, y\], found none"),
        ("slides", [[0, "1"]] * 68, r"slide 0: expected \[x, y\]"),
    ],
)
def test_what_are_no_spreads_visibilities_or_slides_is_refused(tmp_path, key, value, message):
    points = np.random.default_rng(0).uniform(0, 100, (68, 2)).tolist()
    text = json.dumps({"schema": "caricli.landmarks/1", "scheme": "ibug68", "points": points, key: value})
    (tmp_path / "marks.json").write_text(text)
    with pytest.raises(InputError, match=message):
        read_landmarks(tmp_path / "marks.json")


def test_a_byte_order_mark_before_json_is_passed_over(tmp_path):
    np.testing.assert_allclose(read(tmp_path, "\ufeff" + as_json(circle()), "a.json").points, circle())
