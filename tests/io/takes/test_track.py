import json

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.npz import write_npz
from caricli.io.takes.track import read_weights
from caricli.methods.animate.resample_weights import resample_weights
from caricli.store.any_file import load_any
from caricli.structures import Track
from caricli.structures.arkit import ARKIT_NAMES
from tests.written_weights import write_weights

ANGLES = (
    "HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw,LeftEyePitch,LeftEyeRoll,RightEyeYaw,RightEyePitch,RightEyeRoll"
).split(",")
PASCAL = [name[0].upper() + name[1:] for name in ARKIT_NAMES]
WEIGHTS = np.random.default_rng(11).random((4, 52)).round(6)
HEAD = np.random.default_rng(12).normal(size=(4, 3)).round(6)


def live_link(path, weights=WEIGHTS, head=HEAD, timecodes=None, names=PASCAL, count="BlendShapeCount"):
    """A take as Epic's Live Link Face writes it: 52 shapes, nine angles."""
    timecodes = timecodes or [f"14:03:52:{k:02d}.{200 + k}" for k in range(len(weights))]
    angles = np.zeros((len(weights), 9))
    angles[:, :3] = head
    lines = [",".join(["Timecode", count, *names, *ANGLES])]
    lines += [f"{t},61,{','.join(map(str, [*w, *a]))}" for t, w, a in zip(timecodes, weights, angles, strict=True)]
    path.write_text("\n".join(lines) + "\n")
    return path


def category(index, name, score, snake):
    key = ("category_name", "display_name") if snake else ("categoryName", "displayName")
    return {"index": index, "score": score, key[1]: "", key[0]: name}


def result(weights, snake=False):
    """Categories of one face as MediaPipe's Face Landmarker gives them."""
    names = ["_neutral", *sorted(set(ARKIT_NAMES) - {"tongueOut"})]
    scores = [0.01, *(weights[ARKIT_NAMES.index(name)] for name in names[1:])]
    return [category(k, name, float(score), snake) for k, (name, score) in enumerate(zip(names, scores, strict=True))]


def written(path, value):
    path.write_text(json.dumps(value))
    return path


def test_the_columns_are_arkits_names():
    assert len(ARKIT_NAMES) == len(set(ARKIT_NAMES)) == 52


def test_a_live_link_take(tmp_path):
    track = read_weights(live_link(tmp_path / "a.csv"))
    assert track.names == ARKIT_NAMES
    np.testing.assert_array_equal(track.weights, WEIGHTS)
    np.testing.assert_array_equal(track.head, HEAD)
    np.testing.assert_allclose(track.times, np.arange(4) * 1.001 / 60)


@pytest.mark.parametrize("count", ["BlendShapeCount", "BlendshapeCount"])
def test_either_spelling_and_any_order_of_columns(tmp_path, count):
    order = np.random.default_rng(1).permutation(52)
    camel = [ARKIT_NAMES[k] for k in order]
    track = read_weights(live_link(tmp_path / "a.csv", WEIGHTS[:, order], names=camel, count=count))
    np.testing.assert_array_equal(track.weights, WEIGHTS)


def test_windows_ends_byte_order_mark_empty_last_lines_and_no_head(tmp_path):
    path = live_link(tmp_path / "a.csv")
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n") + b"\r\n,,,\r\n")
    np.testing.assert_array_equal(read_weights(path).weights, WEIGHTS)
    lines = [",".join(line.split(",")[:54]) for line in path.read_text("utf-8-sig").splitlines()[:5]]
    path.write_text("\n".join(lines))
    track = read_weights(path)
    assert track.head is None
    np.testing.assert_array_equal(track.weights, WEIGHTS)


@pytest.mark.parametrize(
    ("timecodes", "fps", "times"),
    [
        (["10:00:00:58", "10:00:00:59", "10:00:01:00", "10:00:01:02"], None, [0, 1 / 60, 2 / 60, 4 / 60]),
        (["10:00:00:28.5", "10:00:00:29.5", "10:00:01:00.5", "10:00:01:01"], None, [0, 1 / 30, 2 / 30, 2.5 / 30]),
        (["10:00:00:28", "10:00:00:29", "10:00:00:30", "10:00:00:32"], 50, [0, 0.02, 0.04, 0.08]),
        (["23:59:59:22", "23:59:59:23", "00:00:00:00", "00:00:00:01"], None, [0, 1 / 24, 2 / 24, 3 / 24]),
        (["10:00:00:05"] * 4, None, [0, 1 / 60, 2 / 60, 3 / 60]),
        (["10:00:00:07", "10:00:00:06", "10:00:00:05", "10:00:00:04"], 10, [0, 0.1, 0.2, 0.3]),
        (["0.00", "0.01", "0.02", "0.03"], 30, [0, 1 / 30, 2 / 30, 3 / 30]),
    ],
)
def test_timecodes_become_seconds(tmp_path, timecodes, fps, times):
    track = read_weights(live_link(tmp_path / "a.csv", timecodes=timecodes), fps)
    np.testing.assert_allclose(track.times, times, atol=1e-9)


@pytest.mark.parametrize(
    "shape",
    [
        lambda frames: [{"faceBlendshapes": [{"categories": f, "headIndex": -1}], "faceLandmarks": []} for f in frames],
        lambda frames: [{"face_blendshapes": [f, f[:1]]} for f in frames],
        lambda frames: {"frames": frames},
        lambda frames: [{"categories": f[::-1]} for f in frames],
        lambda frames: frames,
    ],
)
@pytest.mark.parametrize("snake", [False, True])
def test_mediapipe_results_in_every_published_shape(tmp_path, shape, snake):
    track = read_weights(written(tmp_path / "a.json", shape([result(w, snake) for w in WEIGHTS])))
    assert set(track.names) == set(ARKIT_NAMES) - {"tongueOut"} and track.head is None
    expected = WEIGHTS[:, [ARKIT_NAMES.index(name) for name in track.names]]
    np.testing.assert_array_equal(track.weights, expected)
    np.testing.assert_allclose(track.times, np.arange(4) / 30)


def test_mediapipe_single_results_rates_stamps_and_frames_without_a_face(tmp_path):
    frames = [result(w) for w in WEIGHTS]
    for value in (frames[0], {"face_blendshapes": [frames[0]]}):
        track = read_weights(written(tmp_path / "a.json", value))
        assert track.times.tolist() == [0] and track.weights.shape == (1, 51)
    assert read_weights(written(tmp_path / "a.json", frames), 25).times[1] == 0.04
    assert read_weights(written(tmp_path / "a.json", [[], frames[0], [], [], frames[1]]), 10).times[1] == pytest.approx(
        0.3
    )
    stamped = [{"timestampMs": 1000 + 40 * k, "faceBlendshapes": [{"categories": f}]} for k, f in enumerate(frames)]
    stamped[0]["faceBlendshapes"] = stamped[2]["faceBlendshapes"] = []
    track = read_weights(written(tmp_path / "a.json", stamped))
    np.testing.assert_allclose(track.times, [0, 0.08])
    np.testing.assert_array_equal(track.weights[1, track.names.index("jawOpen")], WEIGHTS[3, 17])


@pytest.mark.parametrize("times", [np.arange(4) / 24, [0, 0.1, 0.15, 2]])
@pytest.mark.parametrize("head", [None, HEAD])
def test_our_json_comes_back_as_it_was(tmp_path, times, head):
    given = Track(("jawOpen", "grin"), np.asarray(times), WEIGHTS[:, :2], head)
    write_weights(tmp_path / "a.json", given)
    track = read_weights(tmp_path / "a.json")
    assert track.names == given.names and (track.head is None) == (head is None)
    np.testing.assert_array_equal(track.times, given.times)
    np.testing.assert_array_equal(track.weights, given.weights)
    if head is not None:
        np.testing.assert_array_equal(track.head, head)


def test_arkits_names_take_arkits_spelling_and_others_keep_theirs(tmp_path):
    value = {"schema": "caricli.weights/1", "fps": 30, "names": ["JawOpen", "Grin"], "weights": [[0, 1]]}
    assert read_weights(written(tmp_path / "a.json", value)).names == ("jawOpen", "Grin")


def test_npz(tmp_path):
    arrays = {"names": np.array(["JawOpen", "tongueOut"]), "weights": WEIGHTS[:, :2].astype(np.float32)}
    for fps, more in ((30, {}), (12, {"fps": np.array(12.0)})):
        write_npz(tmp_path / "a.npz", arrays | more)
        track = read_weights(tmp_path / "a.npz")
        assert track.names == ("jawOpen", "tongueOut") and track.times[1] == 1 / fps
        np.testing.assert_allclose(track.weights, WEIGHTS[:, :2], atol=1e-7)
        # Of a recording that says its rate no other is believed.
        assert read_weights(tmp_path / "a.npz", 50).times[1] == (1 / 12 if more else 1 / 50)


def refused(path, *words, fps=None):
    with pytest.raises(InputError) as caught:
        read_weights(path, fps)
    said = str(caught.value)
    assert "\n" not in said and all(word in said for word in words), said


def test_bad_takes_say_the_line(tmp_path):
    path = live_link(tmp_path / "a.csv")
    lines = path.read_text().splitlines()

    def check(number, change, *words):
        path.write_text("\n".join([change(line) if k == number else line for k, line in enumerate(lines, 1)]))
        refused(path, "a.csv", *words)

    def value(line, column, text):
        words = line.split(",")
        words[column] = text
        return ",".join(words)

    check(1, lambda line: line.replace("Left", "L").replace("Mouth", ""), "line 1: expected the columns eyeBlinkLeft,")
    check(2, lambda line: line.rsplit(",", 61)[0], "line 2: expected 63 values", "found 2")
    check(1, lambda line: line.replace("JawOpen", "EyeBlinkLeft"), "line 1", "'EyeBlinkLeft' twice")
    check(1, lambda line: line.replace("HeadPitch", "Nod"), "line 1", "HeadPitch")
    check(1, lambda line: line.replace("BlendShapeCount", "Count"), "BlendShapeCount")
    check(1, lambda line: line.replace("Timecode", "Time"), "expected weights (CSV, JSON or NPZ)")
    check(3, lambda line: line.rpartition(",")[0], "line 3: expected 63 values", "found 62")
    check(4, lambda line: line + ",0", "line 4", "found 64")
    check(3, lambda line: value(line, 5, "much"), "line 3: EyeLookOutLeft: expected a number, found 'much'")
    check(3, lambda line: value(line, 5, ""), "line 3: EyeLookOutLeft", "found ''")
    check(5, lambda line: value(line, 2, "nan"), "line 5: EyeBlinkLeft: expected a number", "found 'nan'")
    check(5, lambda line: value(line, 2, "1.6"), "line 5: eyeBlinkLeft", "from -0.5 to 1.5, found 1.6")
    check(2, lambda line: value(line, 53, "-inf"), "line 2: TongueOut: expected a number", "found '-inf'")
    check(2, lambda line: value(line, 54, "99"), "line 2", "angles of the head in radians")
    check(2, lambda line: value(line, 55, "90"), "line 2", "angles of the head in radians")
    path.write_bytes(b"\xef\xbb\xbf")
    refused(path, "a.csv: expected weights (CSV, JSON or NPZ), found ''")
    path.write_text(lines[0] + "\n\n")
    refused(path, "at least one frame")


@pytest.mark.parametrize("form", [{"between": ";"}, {"between": ";", "point": ","}, {"coding": "utf-16"}])
def test_takes_as_spreadsheets_save_them(tmp_path, form):
    path = live_link(tmp_path / "a.csv")
    text = path.read_text().replace(",", form.get("between", ",")).replace(".", form.get("point", "."))
    path.write_bytes(text.encode(form.get("coding", "utf-8")))
    track = read_weights(path)
    np.testing.assert_array_equal(track.weights, WEIGHTS)
    np.testing.assert_array_equal(track.head, HEAD)
    np.testing.assert_allclose(track.times, np.arange(4) * 1.001 / 60)
    assert load_any(path).names == ARKIT_NAMES


def test_a_take_whose_values_are_all_in_quotes(tmp_path):
    path = live_link(tmp_path / "a.csv")
    rows = [line.split(",") for line in path.read_text().splitlines()]
    rows[2] = [rows[2][0], "0", *[""] * 61]
    path.write_text("\n".join(",".join(f'"{word}"' for word in row) for row in [*rows, [""] * 63]))
    track = read_weights(path)
    np.testing.assert_array_equal(track.weights, WEIGHTS[[0, 2, 3]])
    np.testing.assert_allclose(track.times, np.array([0, 2, 3]) * 1.001 / 60)
    path.write_text(path.read_text().replace(f'"{WEIGHTS[3, 4]}"', f'{WEIGHTS[3, 4]}"'))
    refused(path, f"line 5: EyeLookUpLeft: expected a number, found '{WEIGHTS[3, 4]}\"'")


def test_rows_without_a_face_are_left_out_and_the_others_keep_their_times(tmp_path):
    path = live_link(tmp_path / "a.csv")
    lines = path.read_text().splitlines()
    for lost in ((3,), (1, 2), (4,)):
        rows = [",".join([*line.split(",")[:1], "0"]) if k in lost else line for k, line in enumerate(lines)]
        path.write_text("\n".join(rows))
        track = read_weights(path)
        kept = np.setdiff1d(np.arange(4), np.array(lost) - 1)
        np.testing.assert_array_equal(track.weights, WEIGHTS[kept])
        np.testing.assert_allclose(track.times, (kept - kept[0]) * 1.001 / 60, atol=1e-9)
    path.write_text("\n".join([lines[0], "14:03:52:00.200,0"]))
    refused(path, "at least one frame")


def test_shapes_that_a_take_lacks_are_not_read(tmp_path):
    few = [name for name in ARKIT_NAMES if name not in ("tongueOut", "jawOpen")]
    places = [ARKIT_NAMES.index(name) for name in few]
    track = read_weights(live_link(tmp_path / "a.csv", WEIGHTS[:, places], names=few))
    assert track.names == tuple(few)
    np.testing.assert_array_equal(track.weights, WEIGHTS[:, places])
    np.testing.assert_array_equal(track.head, HEAD)


def test_a_take_of_one_frame_keeps_its_rate(tmp_path):
    path = live_link(tmp_path / "a.csv", WEIGHTS[:1], HEAD[:1])
    for fps, expected in ((None, 60), (24, 24)):
        assert resample_weights(read_weights(path, fps))[1] == expected
    write_weights(tmp_path / "a.json", read_weights(path))
    assert resample_weights(read_weights(tmp_path / "a.json"))[1] == 60


def test_bad_mediapipe_results_say_the_frame(tmp_path):
    path = tmp_path / "a.json"

    def check(change, *words):
        frames = [result(w) for w in WEIGHTS]
        path.write_text(json.dumps(change(frames)))
        refused(path, "a.json", *words)

    def patched(frames, **change):
        frames[1][3] |= change
        return frames

    check(lambda frames: patched(frames, score=2.0), "frame 1: browInnerUp", "found 2")
    check(lambda frames: patched(frames, score="0.5"), "frame 1", "a name and a score")
    check(lambda frames: patched(frames, categoryName=None), "frame 1", "a name and a score")
    check(lambda frames: patched(frames, categoryName="jawOpen"), "frame 1", "'jawOpen' twice")
    check(lambda frames: [frames[0], frames[1][:-1]], "frame 1: expected the same names in all frames")
    check(lambda frames: [{"face_blendshapes": []}], "blendshapes of a face, found none")
    check(lambda frames: [], "found none")
    check(lambda frames: {"faces": frames}, "expected MediaPipe blendshapes")
    check(lambda frames: [3], "frame 0: expected MediaPipe blendshapes, found 3")
    stamps = [{"timestamp_ms": 5}, {}], [{"timestamp_ms": 5}, {"timestamp_ms": 5}]
    stamps += ([{"timestamp_ms": 5}, {"timestamp_ms": 1e308}],)
    said = ("frame 1: expected a timestamp", "frame 1: expected times that rise", "frame 1: expected a timestamp of at")
    for pair, words in zip(stamps, said, strict=True):
        check(lambda f, p=pair: [{"categories": c} | s for c, s in zip(f[:2], p, strict=True)], words)


def test_bad_values_of_our_json(tmp_path):
    good = {"schema": "caricli.weights/1", "fps": 30, "names": ["a", "b"], "weights": [[0, 1], [1, 0]]}
    for change, word in (
        ({"schema": "caricli.rig/1"}, "schema"),
        ({"fps": 0}, "fps: expected from 0.001 to 1000 frames"),
        ({"fps": 1e-320}, "fps: expected from 0.001 to 1000 frames"),
        ({"fps": -1}, "fps"),
        ({"fps": True}, "fps"),
        ({"fps": 1e9}, "fps"),
        ({"times": [0, 1]}, "fps or times"),
        ({"names": ["a", "a"]}, "'a' twice"),
        ({"names": ["a", ""]}, "names"),
        ({"names": "ab"}, "names"),
        ({"names": []}, "at least one frame of weights, found 2 of 0 names"),
        ({"weights": []}, "at least one frame"),
        ({"weights": [[], []], "names": []}, "at least one frame of weights, found 2 of 0 names"),
        ({"weights": [[0, 1], [1]]}, "row 1: expected 2 numbers, found 1"),
        ({"weights": [[0, 1], [1, None]]}, "row 1"),
        ({"weights": [[0, 1], [1, True]]}, "row 1"),
        ({"weights": {"a": 1}}, "at least one frame"),
        ({"weights": [[0, 1], [1, -0.6]]}, "frame 1: b"),
        ({"head": [[0, 0, 0]]}, "head"),
        ({"head": 3}, "head"),
        ({"more": 1}, "names, weights"),
    ):
        refused(written(tmp_path / "a.json", good | change), "a.json", word)
    for times, word in (
        ([0, 0], "frame 1: expected times that rise"),
        ([1, 2], "frame 0"),
        ([0], "times"),
        (0, "times"),
    ):
        value = {key: good[key] for key in ("schema", "names", "weights")} | {"times": times}
        refused(written(tmp_path / "a.json", value), word)
    for text in ('{"schema": "caricli.weights/1", "fps": NaN}', "{", "[1"):
        (tmp_path / "a.json").write_text(text)
        refused(tmp_path / "a.json", "strict JSON")
    refused(written(tmp_path / "a.json", good), "--source-fps", fps=0)


def test_bad_npz_and_other_files(tmp_path):
    good = {"names": np.array(["a", "b"]), "weights": np.zeros((3, 2))}
    for change, word in (
        ({"names": np.array([1, 2])}, "names (K,)"),
        ({"names": np.array(["a"])}, "(T,1)"),
        ({"names": np.array(["a", "a"])}, "twice"),
        ({"weights": np.zeros((0, 2))}, "at least one frame"),
        ({"weights": np.zeros(2)}, "(T,2)"),
        ({"weights": np.array([[0, np.nan]])}, "found nan"),
        ({"weights": np.array([["0", "1"]])}, "names (K,)"),
        ({"fps": np.array(0)}, "fps"),
        ({"fps": np.array([1, 2])}, "fps"),
        ({"more": np.zeros(2)}, "names, weights and fps"),
    ):
        write_npz(tmp_path / "a.npz", good | change)
        refused(tmp_path / "a.npz", "a.npz", word)
    refused(tmp_path / "none.csv", "no such file")
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    refused(tmp_path / "a.png", "a PNG image")
    (tmp_path / "a.csv").write_text("hello\n")
    refused(tmp_path / "a.csv", "found 'hello'")


def test_the_head_of_a_mediapipe_take_turns_by_its_matrices(tmp_path):
    matrix = np.eye(4)
    matrix[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    frames = [
        {
            "faceBlendshapes": [{"categories": result(w)}],
            "facialTransformationMatrixes": [{"data": m.T.ravel().tolist()}],
        }
        for w, m in zip(WEIGHTS, [np.eye(4), matrix, matrix, matrix], strict=True)
    ]
    track = read_weights(written(tmp_path / "a.json", frames))
    np.testing.assert_allclose(track.head[:2], np.array([[0, 0, 0], [np.pi / 2, 0, 0]]), atol=1e-12)
    # A result without a face has no matrix either, and is left out.
    frames[2] = {"faceBlendshapes": [], "facialTransformationMatrixes": []}
    assert read_weights(written(tmp_path / "a.json", frames)).head.shape == (3, 3)


def test_a_drop_frame_take_keeps_its_pace_over_a_minute(tmp_path):
    timecodes = [*(f"10:00:59;{k:02d}.250" for k in range(58, 60)), *(f"10:01:00;{k:02d}.250" for k in range(4, 6))]
    track = read_weights(live_link(tmp_path / "a.csv", timecodes=timecodes))
    np.testing.assert_allclose(track.times, np.arange(4) * 1.001 / 60, atol=1e-9)


@pytest.mark.parametrize(("limit", "most"), [("MAX_FRAMES", 4), ("MAX_SHAPES", 55), ("MAX_WEIGHTS", 4 * 55)])
def test_each_limit_of_its_own_refuses_a_track(tmp_path, monkeypatch, limit, most):
    path = live_link(tmp_path / "a.csv")
    monkeypatch.setattr(f"caricli.io.takes.track.{limit}", most)
    assert len(read_weights(path).weights) == 4
    monkeypatch.setattr(f"caricli.io.takes.track.{limit}", most - 1)
    with pytest.raises(InputError, match="expected at most"):
        read_weights(path)
