import json

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.structures.landmarks import EXTRA_NAMES
from caricli.template.annotation import CAVITIES, DELICATE, bundled_annotation, check_keys, parse_annotation

COUNT = 200


def good(**changes):
    value = {
        "ibug68": list(range(68)),
        "extra13": list(range(100, 113)),
        "jaw_paths": [[k, 120 + k, 150] for k in range(17)],
        "curves": {"brow": [5, 6, 7]},
        "regions": {"face": [0, 1, 199], "nothing": []},
        "mirror": [k + 1 if k % 2 == 0 else k - 1 for k in range(COUNT)],
        "eyeballs": {"left": {"centre": [0, 0, 0], "radius": 1}},
    }
    return value | changes


def without(*keys):
    return {key: value for key, value in good().items() if key not in keys}


def test_everything_is_read_as_arrays():
    annotation = parse_annotation(good(), COUNT, "a.json")
    assert annotation.landmarks.tolist() == [*range(68), *range(100, 113)]
    assert annotation.has_extra
    assert [path.tolist() for path in annotation.jaw_paths] == good()["jaw_paths"]
    assert annotation.curves["brow"].tolist() == [5, 6, 7]
    assert annotation.regions["face"].dtype.kind == "i"
    assert annotation.mirror[:4].tolist() == [1, 0, 3, 2]
    assert annotation.source == good()


def test_a_name_without_vertices_is_as_good_as_none():
    annotation = parse_annotation(good(curves={"lid": [], "brow": [5, 6]}), COUNT, "a.json")
    assert list(annotation.curves) == ["brow"] and list(annotation.regions) == ["face"]


def test_only_the_68_landmarks_are_required():
    annotation = parse_annotation({"ibug68": list(range(68))}, 68, "a.json")
    assert not annotation.has_extra and len(annotation.landmarks) == 68
    # Without paths every jaw landmark stays where it is.
    assert [path.tolist() for path in annotation.jaw_paths] == [[k] for k in range(17)]
    assert annotation.mirror is None
    assert annotation.curves == annotation.regions == annotation.eyeballs == {}


@pytest.mark.parametrize("key", ["extra13", "jaw_paths", "curves", "regions", "mirror", "eyeballs"])
def test_each_other_part_may_be_absent(key):
    annotation = parse_annotation(without(key), COUNT, "a.json")
    assert len(annotation.landmarks) == (68 if key == "extra13" else 81)


def test_anchors_are_landmarks_and_paths_without_repeats():
    anchors = parse_annotation(good(), COUNT, "a.json").anchor_ids()
    assert anchors.tolist() == sorted({*range(68), *range(100, 113), *range(120, 137), 150})


def test_vertices_may_be_used_twice_in_one_part_of_the_face():
    closed = [*range(60), 48, 60, 61, 62, 54, 62, 61, 60]
    assert parse_annotation(good(ibug68=closed), COUNT, "a.json").landmarks[:68].tolist() == closed


@pytest.mark.parametrize(
    ("ids", "message"),
    [
        ([3] * 68, "expected at least 9 vertices for jaw, found 1"),
        ([*range(36), *[36] * 6, *range(42, 68)], "expected at least 3 vertices for eye_right, found 1"),
        ([*range(42), 39, *range(43, 68)], "expected other vertices for eye_left than eye_right, found 39 in both"),
        ([*range(67), 8], "expected other vertices for mouth than jaw, found 8 in both"),
    ],
)
def test_landmarks_that_no_face_can_have_are_refused(ids, message):
    with pytest.raises(InputError, match=f"^a.json: ibug68: {message}"):
        parse_annotation(good(ibug68=ids), COUNT, "a.json")


def test_the_wrong_one_of_many_ids_is_shown():
    ids = [*range(67), COUNT]
    for change, key in (({"ibug68": ids}, "ibug68"), ({"regions": {"face": ids}}, "regions.face")):
        with pytest.raises(InputError, match=rf"from 0 to 199, found 200 at {key}\[67\]$"):
            parse_annotation(good(**change), COUNT, "a.json")


def test_ids_up_to_the_last_vertex_are_taken():
    assert parse_annotation(good(ibug68=[*range(67), COUNT - 1]), COUNT, "a.json").landmarks[67] == COUNT - 1


NOT_IDS = {
    "out of range": [*range(67), COUNT],
    "negative": [*range(67), -1],
    "float": [*range(67), 7.0],
    "bool": [*range(67), True],
    "text": [*range(67), "7"],
    "null": [*range(67), None],
    "nested": [[k] for k in range(68)],
    "ragged": [*range(67), [1, 2]],
    "no list": 7,
    "an object": {"a": 1},
    "huge": [*range(67), 10**30],
}


@pytest.mark.parametrize("ids", NOT_IDS.values(), ids=NOT_IDS.keys())
def test_what_is_no_list_of_vertex_ids_is_refused(ids):
    for change in ({"ibug68": ids}, {"curves": {"brow": ids}}, {"regions": {"face": ids}}, {"mirror": ids}):
        message = f"^a.json: {next(iter(change))}.*: expected a list of vertex ids from 0 to 199, found "
        with pytest.raises(InputError, match=message) as refusal:
            parse_annotation(good(**change), COUNT, "a.json")
        assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ibug68": list(range(67))}, "ibug68: expected 68 vertex ids, found 67"),
        ({"ibug68": list(range(69))}, "ibug68: expected 68 vertex ids, found 69"),
        ({"ibug68": []}, "ibug68: expected 68 vertex ids, found 0"),
        ({"extra13": list(range(12))}, "extra13: expected 13 vertex ids, found 12"),
        ({"mirror": list(range(COUNT - 1))}, "mirror: expected 200 vertex ids, found 199"),
        ({"mirror": [*range(1, COUNT), 0]}, "mirror: expected a map that is its own inverse, found another"),
        ({"mirror": [0] * COUNT}, "mirror: expected a map that is its own inverse, found another"),
        ({"jaw_paths": [[k] for k in range(16)]}, "jaw_paths: expected 17 lists of vertex ids, found "),
        ({"jaw_paths": {"a": [1]}}, "jaw_paths: expected 17 lists of vertex ids, found "),
        (
            {"jaw_paths": [[k + 1] for k in range(17)]},
            "jaw_paths\\[0\\]: expected vertex 0, which slides",
        ),
        ({"jaw_paths": [[]] + [[k] for k in range(1, 17)]}, "jaw_paths\\[0\\]: expected vertex 0, which"),
        ({"jaw_paths": [[0.0]] + [[k] for k in range(1, 17)]}, "jaw_paths\\[0\\]: expected a list of vertex ids"),
        ({"jaw_paths": [0] + [[k] for k in range(1, 17)]}, "jaw_paths\\[0\\]: expected a list of vertex ids"),
        ({"curves": [1, 2]}, "curves: expected dict, found list"),
        ({"regions": None}, "regions: expected dict, found NoneType"),
        ({"eyeballs": [1]}, "eyeballs: expected dict, found list"),
        ({"closed_curves": None}, "closed_curves: expected list, found NoneType"),
    ],
    ids=str,
)
def test_parts_that_do_not_fit_are_refused(change, message):
    with pytest.raises(InputError, match=f"^a.json: {message}"):
        parse_annotation(good(**change), COUNT, "a.json")


@pytest.mark.parametrize("value", [None, [], [1, 2], "ibug68", 3.0])
def test_what_is_no_object_is_refused(value):
    with pytest.raises(InputError, match="^a.json: expected a JSON object"):
        parse_annotation(value, COUNT, "a.json")


def test_missing_landmarks_are_refused():
    with pytest.raises(InputError, match="ibug68: expected a list of vertex ids from 0 to 199, found none"):
        parse_annotation(without("ibug68"), COUNT, "a.json")


def test_the_bundled_annotation_is_good_and_fits_only_its_mesh():
    value = json.loads(asset_path("head_annotation.json").read_text())
    annotation = parse_annotation(value, 4200, "head_annotation.json")
    assert annotation.has_extra and len(np.unique(annotation.landmarks)) == 81
    assert len(EXTRA_NAMES) == len(value["extra13_names"]) == 13
    for name in ("face", "scalp", "inner_mouth", "eye_socket_left"):
        assert len(annotation.regions[name]) > 20
    assert {*CAVITIES, *DELICATE} <= set(annotation.regions)
    bundled = bundled_annotation()
    assert bundled is bundled_annotation() and bundled.source == value and len(bundled.mirror) == 4200
    with pytest.raises(InputError, match="from 0 to 4198"):
        parse_annotation(value, 4199, "head_annotation.json")


def test_keys_that_mean_nothing_are_refused():
    check_keys(bundled_annotation().source)
    for key, meant in (("extra_13", "extra13"), ("jawpaths", "jaw_paths")):
        with pytest.raises(InputError, match=f"expected keys of ibug68, .*found '{key}'; is {meant} meant"):
            check_keys(good() | {key: []})
    with pytest.raises(InputError, match="closed_curves: expected names of curves, found 'nonsense'"):
        check_keys(good() | {"closed_curves": ["nonsense"]})
