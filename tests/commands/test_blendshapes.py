import json

import numpy as np
import pytest
import torch

from caricli.io.checkpoint import write_checkpoint
from caricli.io.face import read_face, write_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.npz import read_npz, write_npz
from caricli.io.rig import read_rig
from caricli.io.strict_json import read_json
from caricli.methods.rig.measure_rig import curve_gap
from caricli.models.texture.config import TextureSize
from caricli.models.texture.model import TextureModel, texture_to_checkpoint
from caricli.models.texture.networks import TextureNetwork
from caricli.structures import Face, Landmarks, Material
from caricli.structures.arkit import ARKIT_NAMES

pytestmark = pytest.mark.usefixtures("quick_pictures")

SET = "neutral: {}\nsmile: {mouthSmile: 0.9}\nopen: {jawOpen: 0.8}\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("blendshapes")


@pytest.fixture(scope="module")
def landmarks(head, head_template, folder):
    """Those of a laughing head in front."""
    laugh = {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9, "jawOpen": 0.35}
    face = head.evaluate(gender=0.2, age=0.8, actions=laugh)
    marks = 1400 * face[head_template.annotation.landmarks[:68], :2] * [1, -1] + [200, 320]
    write_landmarks(folder / "marks.json", Landmarks(marks, (400, 400)))
    return folder / "marks.json"


@pytest.fixture(scope="module")
def face(run, landmarks, folder):
    """A reconstructed face."""
    result = run("reconstruct-from-landmarks", landmarks, "--out", folder / "face.obj")
    assert result.exit_code == 0, result.output
    return folder / "face.npz"


@pytest.fixture(scope="module")
def moods(folder):
    (folder / "set.yaml").write_text(SET)
    return folder / "set.yaml"


@pytest.fixture(scope="module")
def blended(run, face, quick_pictures, folder):
    """The path of blendshapes, made by the command, and what the command said."""
    out = folder / "new" / "b.npz"
    result = run("blendshapes", face, "--out", out)
    assert result.exit_code == 0, result.output
    return out, result


def test_a_face_gets_arkits_expressions(blended, face):
    out, result = blended
    assert sorted(path.name for path in out.parent.iterdir()) == ["b.glb", "b.json", "b.npz", "b.png"]
    assert result.stdout.startswith(f"{out}: 52 expressions, ") and result.stdout.count("\n") == 1
    rig = read_rig(out)
    assert sorted(rig.names) == sorted(ARKIT_NAMES)
    assert rig.normal_deltas.shape == (52, 4200, 3) and len(rig.neutral) > 4200
    # The picture shows a laugh, the neutral face less of it; the skull is where it was.
    moved = np.linalg.norm(rig.neutral[:4200] - read_face(face).vertices, axis=1)
    assert 0.001 < moved.max() < 0.03 and (moved < 1e-6).sum() > 500
    jaw = rig.names.index("jawOpen")
    assert rig.deltas[jaw, :, 1].min() < -0.01
    picture = read_image(out.with_suffix(".png"))
    assert picture.shape[1] >= 9 * 48 and picture.shape[0] >= 6 * 48


def test_the_glb_holds_the_same(blended):
    rig, glb = read_rig(blended[0]), read_gltf(blended[0].with_suffix(".glb"))
    assert glb.names == rig.names
    np.testing.assert_allclose(glb.deltas, rig.deltas, atol=1e-6)


def test_the_report_says_what_every_expression_is_and_does(blended, face):
    report = read_json(blended[0].with_suffix(".json"))
    assert report["command"] == "blendshapes" and report["method"] == "full" and report["weights"] == [1.0, 0.1, 0.05]
    assert str(face) in report["inputs"] and report["seconds"] > 0 and report["structure"] < 0.5
    rows = report["expressions"]
    assert len(rows) == 53 and next(iter(rows)) == "neutral" and rows["jawOpen"]["weights"] == {"jawOpen": 1.0}
    for name, row in rows.items():
        still = name in ("neutral", "tongueOut")
        assert row.get("drift", 0) < 0.001 and (still or 0.3 < row["strength"] < 2), name


def test_its_eyes_look_aside_and_its_lips_close_on_an_open_jaw(blended, head_template):
    rig = read_rig(blended[0])
    for name in ("eyeLookInLeft", "eyeLookOutLeft", "eyeLookInRight", "eyeLookOutRight"):
        balls = rig.deltas[rig.names.index(name), 4200 : 4200 + 2 * 314]
        assert np.abs(balls[:, 0]).max() > 0.003, name
    out = rig.deltas[rig.names.index("tongueOut")].any(1)
    # Lips part for it, and the jaw takes the lower teeth along.
    assert {Material.TONGUE, Material.SKIN} < set(rig.triangle_materials[out[rig.faces].any(1)])
    lips = [head_template.annotation.curves[f"mouth_inner_{lip}"] for lip in ("upper", "lower")]
    close, wide, rest = (rig.shape_in_use(rig.names.index("mouthClose")), rig.shape("jawOpen"), rig.neutral)
    assert curve_gap(close[:, :2], *lips) < 0.2 * curve_gap(wide[:, :2], *lips)
    assert curve_gap(rest[:, :2], *lips) < 0.2 * curve_gap(wide[:, :2], *lips)


@pytest.mark.parametrize("more", [("--method", "initial"), ("--method", "transfer"), ("--reconstruct", "latent")])
def test_a_set_of_ones_own_by_any_method(run, landmarks, moods, more, tmp_path):
    out = tmp_path / "b.npz"
    result = run("blendshapes", landmarks, "--expressions", moods, "--parts", "skin", "--out", out, *more)
    assert result.exit_code == 0, result.output
    rig = read_rig(out)
    assert rig.names == ("smile", "open") and len(rig.neutral) == 4200
    assert 0.005 < np.abs(rig.deltas).max() < 0.1 and f"2 expressions, {len(rig.neutral)} vertices" in result.stdout


def test_models_are_known_by_name(run, face, moods, tmp_path):
    for name, model in {"own": (), "named": ("--model", "morphable")}.items():
        out = tmp_path / f"{name}.npz"
        result = run("blendshapes", face, "--expressions", moods, "--parts", "skin", *model, "--out", out)
        assert result.exit_code == 0, result.output
    assert (tmp_path / "own.npz").read_bytes() == (tmp_path / "named.npz").read_bytes()


def test_weights_are_those_of_equation_11(run, face, moods, tmp_path):
    sizes = {}
    for name, weights in {"usual": (1, 0.1, 0.05), "smooth": (1, 0.1, 5)}.items():
        out = tmp_path / f"{name}.npz"
        result = run("blendshapes", face, "--expressions", moods, "--weights", *weights, "--out", out)
        assert result.exit_code == 0, result.output
        sizes[name] = np.abs(read_rig(out).deltas[:, :4200]).sum()
    assert sizes["smooth"] < 0.5 * sizes["usual"]


def test_its_skin_changes_with_its_moods(run, refused, face, moods, head_template, tmp_path):
    network = TextureNetwork(TextureSize(4, 4), torch.Generator().manual_seed(0))
    network.colour.last.bias.data[12:] = 0.2
    model = TextureModel(network, 32, head_template.topology_id)
    write_checkpoint(tmp_path / "network.safetensors", *texture_to_checkpoint(model))
    write_png(tmp_path / "skin.png", np.full((64, 64, 3), 90, np.uint8))
    usual = ("blendshapes", face, "--expressions", moods, "--parts", "skin", "--dynamic-texture")
    chosen = ("--texture-network", tmp_path / "network.safetensors")
    result = run(*usual, *chosen, "--texture", tmp_path / "skin.png", "--out", tmp_path / "b.npz")
    assert result.exit_code == 0, result.output
    rig = read_rig(tmp_path / "b.npz")
    assert [mood.name for mood in rig.moods] == ["smile", "open"]
    assert all((mood.skin != rig.pictures.skin).any() for mood in rig.moods)
    stored = read_gltf(tmp_path / "b.glb")
    assert [mood.name for mood in stored.moods] == ["smile", "open"]
    np.testing.assert_array_equal(stored.changes.picture, rig.changes.picture)
    assert rig.actions[1].max() > 0.5
    assert "a picture on its skin" in refused(*usual, *chosen, "--out", tmp_path / "bare.npz")
    refused("blendshapes", face, *chosen, "--out", tmp_path / "none.npz", code=2)
    (tmp_path / "no.safetensors").write_bytes(b"no network")
    said = refused(*usual, "--texture-network", tmp_path / "no.safetensors", "--out", tmp_path / "none.npz")
    assert "no.safetensors" in said


def test_it_can_be_animated_and_retargeted(run, blended, face, landmarks, tmp_path):
    out, track = blended[0], {"schema": "caricli.weights/1", "fps": 10, "names": ["jawOpen"], "weights": [[0], [1]]}
    (tmp_path / "w.json").write_text(json.dumps(track))
    assert run("animate", out, tmp_path / "w.json", "--out", tmp_path / "talk.glb").exit_code == 0
    result = run("retarget", out, landmarks, "--out", tmp_path / "driven.obj")
    assert result.exit_code == 0, result.output
    assert "mouthSmile" in result.stdout


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("smile: {mouthSmile: 1}\nopen: {jawOpen: 1}", "expected an expression 'neutral'"),
        ("neutral: {}\na: {jawOpen: 1}\na: {jawOpen: 0.5}", "distinct keys, found 'a' twice"),
        ("neutral: {}\na: {jawOpen: -1}", "weights from 0 to 1.5"),
        ("neutral: {}\na: {mouthSmile: 0}", "a: expected a weight above 0"),
    ],
)
def test_bad_sets_are_refused(refused, face, text, words, tmp_path):
    (tmp_path / "set.yaml").write_text(text)
    out = tmp_path / "new" / "b.npz"
    assert words in refused("blendshapes", face, "--expressions", tmp_path / "set.yaml", "--out", out)
    assert not out.parent.exists()


def test_bad_faces_landmarks_and_maps_are_refused(run, refused, face, points, tmp_path):
    out = tmp_path / "new" / "b.npz"
    few = {"schema": "caricli.landmarks/1", "scheme": "ibug68", "points": points[:5].tolist() + [None] * 63}
    (tmp_path / "few.json").write_text(json.dumps(few))
    assert "few.json: expected at least 8" in refused("blendshapes", tmp_path / "few.json", "--out", out)
    seen = read_face(face)
    write_face(tmp_path / "blind.npz", Face(seen.mesh))
    assert "blind.npz: expected a face with the camera" in refused("blendshapes", tmp_path / "blind.npz", "--out", out)
    flat = read_npz(face)
    flat["vertices"][flat["faces"][9, 0]] = flat["vertices"][flat["faces"][9, 1]]
    write_npz(tmp_path / "flat.npz", flat)
    assert "flat.npz: " in refused("blendshapes", tmp_path / "flat.npz", "--out", out)
    assert "kind morphable, found pca" in refused("blendshapes", face, "--model", "pca", "--out", out)
    assert "b.safetensors" in refused("blendshapes", face, "--map", tmp_path / "b.safetensors", "--out", out)
    assert "--weights" in run("blendshapes", face, "--weights", -1, 0, 0, "--out", out).output
    assert "above 0" in refused("blendshapes", face, "--weights", 0, 0, 1, "--out", out)
    said = refused("blendshapes", face.with_suffix(".obj"), "--out", out)
    assert "face.obj: expected FACE.npz, a picture or landmarks, found a mesh, which has no camera" in said
    for more in (("--method", "transfer", "--reconstruct", "latent"), ("--method", "initial", "--weights", 1, 1, 1)):
        result = run("blendshapes", face, "--out", out, *more)
        assert result.exit_code == 2 and more[2] in result.stderr
    refused("blendshapes", face, "--out", face)
    assert not out.parent.exists()


def test_outputs_that_exist_are_refused_before_a_face_is_reconstructed(refused, monkeypatch, tmp_path):
    monkeypatch.setattr("caricli.store.expression_tools.load_caricature", pytest.fail)
    (tmp_path / "b.glb").write_bytes(b"mine")
    said = refused("blendshapes", tmp_path / "drawing.png", "--out", tmp_path / "b.npz")
    assert "b.glb exists; give --overwrite to replace it" in said
