import json
import os

import numpy as np
import pygltflib
import pytest
from scipy.spatial.transform import Rotation

from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import read_image
from caricli.io.meshes.mesh import write_mesh
from caricli.io.meshes.obj import read_obj
from caricli.io.rig import read_rig, write_rig
from caricli.io.strict_json import read_json
from caricli.render.rig_stage import RigStage
from caricli.structures import Mesh, Rig, Track
from caricli.structures.arkit import ARKIT_NAMES
from tests.written_weights import write_weights

SHAPES = ("jawOpen", "mouthSmileLeft", "eyeBlinkLeft", "browInnerUp", "tongueOut")
TIMES = np.arange(6) / 30


@pytest.fixture(scope="module")
def rig_file(ball, tmp_path_factory):
    """A ball with five expressions."""
    vertices, faces = ball
    deltas = 0.02 * np.random.default_rng(4).normal(size=(5, *vertices.shape))
    path = tmp_path_factory.mktemp("rig") / "rig.npz"
    write_rig(path, Rig(SHAPES, Mesh((0.1 * vertices).astype(np.float32), faces), deltas.astype(np.float32)))
    return path


@pytest.fixture(scope="module")
def values():
    """Weights (T, 52) in Live Link Face's order; the tongue, which MediaPipe lacks, stays in."""
    values = np.random.default_rng(6).random((6, 52)).round(5)
    values[:, ARKIT_NAMES.index("tongueOut")] = 0
    return values


def live_link(path, values, head=None, start=40):
    names = [name[0].upper() + name[1:] for name in ARKIT_NAMES]
    angles = "HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw,LeftEyePitch,LeftEyeRoll,RightEyeYaw,RightEyePitch,RightEyeRoll"
    turns = np.zeros((len(values), 9))
    if head is not None:
        turns[:, :3] = head
    lines = [f"Timecode,BlendShapeCount,{','.join(names)},{angles}"]
    for k, row in enumerate(values):
        lines.append(f"09:30:59:{start + 2 * k:02d}.000,61,{','.join(map(str, [*row, *turns[k]]))}")
    path.write_text("\n".join(lines) + "\n")
    return path


def mediapipe(path, values):
    names = ["_neutral", *sorted(set(ARKIT_NAMES) - {"tongueOut"})]
    results = []
    for k, row in enumerate(values):
        scores = {name: row[ARKIT_NAMES.index(name)] if k else 0.2 for k, name in enumerate(names)}
        categories = [
            {"index": i, "score": float(scores[name]), "categoryName": name, "displayName": ""}
            for i, name in enumerate(names)
        ]
        results.append({"faceLandmarks": [], "faceBlendshapes": [{"categories": categories, "headIndex": -1}]})
    path.write_text(json.dumps(results))
    return path


def ours(path, weights, head=None, names=SHAPES, times=None):
    times = np.arange(len(weights)) / 30 if times is None else times
    write_weights(path, Track(tuple(names), times, np.asarray(weights, float), head))
    return path


def posed(rig, weights):
    return rig.neutral + np.einsum("k,kvc->vc", weights, rig.deltas.astype(float))


def test_live_link_and_mediapipe_give_the_same_frames(run, rig_file, values, tmp_path):
    sources = live_link(tmp_path / "take.csv", values), mediapipe(tmp_path / "take.json", values)
    made = []
    for source in sources:
        out, frames = tmp_path / source.suffix[1:] / "anim.glb", tmp_path / f"{source.suffix[1:]}-frames"
        result = run("animate", rig_file, source, "--out", out, "--frames", frames)
        assert result.exit_code == 0, result.output
        driven = 5 - (source.suffix == ".json")
        said = f"{out}: 6 frames at 30 a second, {driven} of 5 expressions driven, "
        assert result.stdout.startswith(said) and result.stdout.endswith(" s\n")
        made.append((out, [read_obj(frames / f"frame-{k:04d}.obj").vertices for k in range(6)]))
    rig = read_rig(rig_file)
    columns = [ARKIT_NAMES.index(name) for name in SHAPES]
    for row, *frames in zip(values, *(frames for _, frames in made), strict=True):
        np.testing.assert_array_equal(*frames)
        np.testing.assert_allclose(frames[0], posed(rig, row[columns]), atol=1e-6)
    for (out, _), source in zip(made, sources, strict=True):
        times, weights, rotations = glb_animation(out)
        np.testing.assert_allclose(times, TIMES, atol=1e-6)
        np.testing.assert_allclose(weights, values[:, columns], atol=1e-6)
        back, report = read_gltf(out), read_json(out.with_suffix(".json"))
        assert back.names == SHAPES
        np.testing.assert_allclose(back.deltas, rig.deltas, atol=1e-6)
        assert set(report["inputs"]) == {str(rig_file), str(source)} and report["frames"] == 6
        assert report["clipped"] == 0 and report["ranges"]["jawOpen"] == [
            pytest.approx(values[:, columns[0]].min()),
            pytest.approx(values[:, columns[0]].max()),
        ]
    assert report["undriven"] == ["tongueOut"] and len(report["unmatched"]) == 47


def glb_animation(path):
    """Times, weights and rotations of the one animation of a GLB, by pygltflib."""
    gltf = pygltflib.GLTF2().load(str(path))
    blob, (animation,) = gltf.binary_blob(), gltf.animations

    def array(index):
        accessor = gltf.accessors[index]
        view = gltf.bufferViews[accessor.bufferView]
        width = {"SCALAR": 1, "VEC4": 4}[accessor.type]
        start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
        return np.frombuffer(blob, "<f4", accessor.count * width, start).reshape(accessor.count, width)

    samplers = {channel.target.path: animation.samplers[channel.sampler] for channel in animation.channels}
    times = array(samplers["weights"].input)[:, 0]
    turns = array(samplers["rotation"].output) if "rotation" in samplers else None
    return times, array(samplers["weights"].output).reshape(len(times), -1), turns


def test_the_head_turns_in_the_glb_and_in_the_frames_alike(run, rig_file, values, tmp_path):
    head = np.linspace([0, 0, 0], [0.5, -0.2, 0.1], 6)
    source, rig = live_link(tmp_path / "take.csv", values, head), read_rig(rig_file)
    columns = [ARKIT_NAMES.index(name) for name in SHAPES]
    for words, turned in (((), True), (("--no-head",), False)):
        out, frames = tmp_path / f"{turned}.glb", tmp_path / f"{turned}"
        result = run("animate", rig_file, source, "--out", out, "--frames", frames, *words)
        assert result.exit_code == 0, result.output
        found, still = read_obj(frames / "frame-0005.obj").vertices, posed(rig, values[5, columns])
        turns = glb_animation(out)[2]
        assert (turns is not None) == turned and read_json(out.with_suffix(".json"))["head"] == turned
        rotation = Rotation.from_quat(turns[5]) if turned else Rotation.identity()
        np.testing.assert_allclose(found, rotation.apply(still), atol=1e-6)
        assert turned == (np.abs(found - still).max() > 1e-3)


def test_pictures_and_videos(run, rig_file, tmp_path):
    weights = np.zeros((4, 5))
    weights[2] = 1
    source, frames = ours(tmp_path / "w.json", weights), tmp_path / "frames"
    options = ("--frames", frames, "--format", "png", "--video", tmp_path / "a.gif", "--view", "profile", "--size", 48)
    result = run("animate", rig_file, source, *options)
    assert result.exit_code == 0 and result.stderr == "", result.output
    assert sorted(p.name for p in frames.iterdir()) == ["animation.json", *(f"frame-000{k}.png" for k in range(4))]
    pictures = [read_image(frames / f"frame-000{k}.png") for k in range(4)]
    assert pictures[0].shape == (48, 48, 3)
    np.testing.assert_array_equal(pictures[0], pictures[1])
    rig = read_rig(rig_file)
    aside = next(iter(RigStage(rig, "profile", 48).pictures([rig.neutral])))
    np.testing.assert_array_equal(pictures[0], aside)
    assert np.abs(pictures[0].astype(int) - pictures[2]).max() > 50
    assert np.abs(read_image(tmp_path / "a.gif").astype(int) - pictures[0]).mean() < 3
    assert read_json(tmp_path / "a.gif.json") == read_json(frames / "animation.json")
    assert "exists" in run("animate", rig_file, source, *options).stderr
    result = run(
        "animate", rig_file, source, "--video", tmp_path / "a.mp4", "--size", 47, "--frames", frames, "--overwrite"
    )
    assert result.exit_code == 0 and (tmp_path / "a.mp4").stat().st_size > 500, result.output
    assert sorted(p.suffix for p in frames.iterdir()) == [".json", *[".obj"] * 4]


def test_rate_smoothing_scale_and_clipping(run, rig_file, tmp_path):
    weights = np.zeros((6, 5))
    weights[:, 0], weights[:, 1], weights[3:, 2] = np.linspace(0, 1, 6), 1.2, 1
    source, out = ours(tmp_path / "w.json", weights, times=TIMES), tmp_path / "a.glb"

    def animated(*words):
        result = run("animate", rig_file, source, "--out", out, "--overwrite", *words)
        assert result.exit_code == 0, result.output
        return glb_animation(out)

    plain = animated()[1]
    np.testing.assert_allclose(plain, np.clip(weights, 0, 1), atol=1e-6)
    assert read_json(tmp_path / "a.json")["clipped"] == 6
    times, finer, _ = animated("--fps", 60)
    np.testing.assert_allclose(times, np.arange(11) / 60, atol=1e-6)
    np.testing.assert_allclose(finer[:, 0], np.linspace(0, 1, 11), atol=1e-6)
    scaled = animated("--scale", "jawOpen=1.5", "--scale", "eyeBlinkLeft=0")[1]
    np.testing.assert_allclose(scaled, plain * [1.5, 1, 0, 1, 1], atol=1e-6)
    smooth = animated("--smooth", 1)[1]
    np.testing.assert_allclose(smooth[:, 1], 1, atol=1e-6)
    assert 0.2 < smooth[3, 2] < 0.98 and np.abs(smooth - plain).max() < 0.8


def test_a_recording_that_does_not_say_its_rate_has_the_one_that_is_told(run, rig_file, values, tmp_path):
    take, cues = mediapipe(tmp_path / "take.json", values), tmp_path / "cues.tsv"
    cues.write_text("0.0\tX\n0.2\tD\n0.6\tX\n")
    for source, frames in ((take, 6), (cues, 16)):
        out = tmp_path / source.suffix[1:] / "anim.glb"
        result = run("animate", rig_file, source, "--out", out, "--source-fps", 25)
        assert result.exit_code == 0, result.output
        np.testing.assert_allclose(glb_animation(out)[0], np.arange(frames) / 25, atol=1e-6)


def test_glb_and_gltf_are_rigs_too_and_names_are_listed(run, rig_file, tmp_path):
    foreign = [tmp_path / "rig.glb", tmp_path / "rig.gltf"]
    for path in foreign:
        write_gltf(path, read_rig(rig_file))
    source = ours(tmp_path / "w.json", [[0.5, 1], [1, 0]], names=("TongueOut", "grin"))
    made = []
    for rig in (rig_file, *foreign):
        result = run("animate", rig, source, "--frames", tmp_path / rig.suffix[1:])
        assert result.exit_code == 0, result.output
        assert result.stderr.count("\n") == 1
        assert result.stderr.endswith("w.json: the rig lacks grin\n")
        made.append(read_obj(tmp_path / rig.suffix[1:] / "frame-0001.obj").vertices)
    np.testing.assert_allclose(made[1:], [made[0]] * 2, atol=1e-6)
    np.testing.assert_allclose(made[0], posed(read_rig(rig_file), [0, 0, 0, 0, 1]), atol=1e-6)


def test_bad_input_is_one_line_and_leaves_nothing(refused, rig_file, ball, values, tmp_path):
    good, place = live_link(tmp_path / "take.csv", values), tmp_path / "new"
    out = ("--out", place / "a.glb", "--frames", place / "frames")

    def check(*words, rig=rig_file, source=good, options=out, code=1):
        said = refused("animate", rig, source, *options, code=code)
        assert all(word in said for word in words), said
        assert not place.exists()

    lines = good.read_text().splitlines()
    for text, word in (
        ("\n".join([lines[0].replace("Left", "L").replace("Mouth", ""), *lines[1:]]), "eyeBlinkLeft"),
        ("\n".join([*lines[:3], lines[3] + ",1"]), "line 4"),
        (lines[0], "at least one frame"),
        ("\n".join([*lines[:2], lines[2].replace("61,", "61,nan,", 1).rpartition(",")[0]]), "found 'nan'"),
        ("\n".join([*lines[:2], lines[2].replace("61,", "61,9,", 1).rpartition(",")[0]]), "found 9"),
    ):
        bad = tmp_path / "bad.csv"
        bad.write_text(text)
        check(word, source=bad)
    zero = {"schema": "caricli.weights/1", "fps": 0, "names": ["jawOpen"], "weights": [[0]]}
    (tmp_path / "zero.json").write_text(json.dumps(zero))
    check("fps: expected from 0.001 to 1000 frames a second, found 0", source=tmp_path / "zero.json")
    check("no such file", source=tmp_path / "none.csv")
    check("no such file", rig=tmp_path / "none.npz")
    check("expected an NPZ file", rig=good)
    check("x.json: weights: expected names of the rig", source=ours(tmp_path / "x.json", [[1.0]], names=("grin",)))
    check("expected a name that ends in .mp4 or .gif", options=("--video", place / "a.avi"), code=2)
    fast = ours(tmp_path / "fast.json", np.zeros((3, 5)), times=np.arange(3) / 60)
    film = os.path.relpath(place / "a.gif")
    check(f" {film}: expected from 0.002 to 50 frames", source=fast, options=(*out, "--video", film))
    check("did you mean 'jawOpen'", options=(*out, "--scale", "jawopen=1"))
    still = tmp_path / "still.glb"
    write_mesh(still, Mesh(*ball))
    check("still.glb: expected a rig with expressions", rig=still, options=(*out, "--scale", "jawOpen=1"))
    for text in ("jawOpen", "jawOpen=", "jawOpen=nan", "jawOpen=4", "jawOpen=-1", "=1"):
        check("NAME=K", options=(*out, "--scale", text), code=2)
    check("every expression once", options=(*out, "--scale", "jawOpen=1", "--scale", "jawOpen=2"), code=2)
    check("ends in .glb", options=("--out", place / "a.obj"), code=2)
    endless = ours(tmp_path / "endless.json", np.zeros((2, 5)), times=np.array([0, 1e9]))
    check("endless.json: weights: expected at most", source=endless, options=(*out, "--fps", "60"))


def test_outputs_are_never_inputs_and_folders_of_others_stay(refused, rig_file, tmp_path):
    source = ours(tmp_path / "a.json", np.zeros((2, 5)))
    assert "one of the inputs" in refused("animate", rig_file, source, "--out", tmp_path / "a.glb")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    said = refused("animate", rig_file, source, "--frames", tmp_path / "mine", "--overwrite")
    assert "animation.json" in said and (tmp_path / "mine" / "letter.txt").exists()


@pytest.mark.parametrize("option", ["--out", "--video"])
def test_nothing_is_written_into_the_folder_of_the_frames(run, refused, rig_file, tmp_path, option):
    source = ours(tmp_path / "a.json", np.zeros((2, 5)))
    line = ("animate", rig_file, source, "--frames", tmp_path / "frames")
    assert run(*line).exit_code == 0
    before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "frames").iterdir()}
    inside = tmp_path / "frames" / ("a.glb" if option == "--out" else "a.gif")
    said = refused(*line, option, inside, "--size", 16, "--overwrite", code=2)
    assert "outside of the folder of --frames" in said
    assert before == {path.name: path.stat().st_mtime_ns for path in (tmp_path / "frames").iterdir()}


@pytest.mark.parametrize(
    "words",
    [[], *(["--out", "a.glb", *more] for more in (["--fps", "0"], ["--smooth", "nan"], ["--format", "png"]))],
)
def test_wrong_usage_is_2(run, rig_file, tmp_path, words):
    result = run("animate", rig_file, ours(tmp_path / "w.json", np.zeros((2, 5))), *words)
    assert result.exit_code == 2 and result.stdout == ""


def test_mouth_cues_and_visemes_make_it_speak(run, refused, rig_file, tmp_path):
    cues = tmp_path / "cues.tsv"
    cues.write_text("0.0\tX\n0.2\tD\n0.5\tA\n0.6\tX\n")
    assert run("animate", rig_file, cues, "--out", tmp_path / "a.glb").exit_code == 0
    found = read_json(tmp_path / "a.json")
    assert found["fps"] == 30 and found["ranges"]["jawOpen"][1] > 0.5 and "mouthClose" in found["unmatched"]
    assert run("animate", rig_file, cues, "--out", tmp_path / "b.glb", "--fps", 50).exit_code == 0
    assert read_json(tmp_path / "b.json")["frames"] == 31
    weights = np.eye(3)[[0, 1, 2, 0]]
    write_weights(tmp_path / "visemes.json", Track(("viseme_sil", "viseme_aa", "viseme_PP"), np.arange(4.0), weights))
    assert run("animate", rig_file, tmp_path / "visemes.json", "--out", tmp_path / "c.glb").exit_code == 0
    assert read_json(tmp_path / "c.json")["ranges"]["jawOpen"] == pytest.approx([0, 0.6])
    cues.write_text("0.0\tX\n0.2\tQ\n")
    assert "cues.tsv: cue 1: expected one of Rhubarb's letters" in refused(
        "animate", rig_file, cues, "--out", tmp_path / "d.glb"
    )
