from dataclasses import replace

import numpy as np
import pytest

from caricli.io.bundled import asset_path
from caricli.io.face import read_face
from caricli.io.image import read_image
from caricli.io.meshes.mesh import read_mesh
from caricli.io.sketches.sketch import read_sketch, write_sketch
from caricli.io.strict_json import read_json
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.structures.sketch import Sketch, Stroke
from caricli.template.feature_curves import feature_curves

COMMAND = "reconstruct-from-sketch"


@pytest.fixture(scope="module")
def drawing(head, head_template, tmp_path_factory):
    """A sketch file of somebody with an open mouth."""
    curves = feature_curves(head_template.annotation)
    vertices = head.evaluate(gender=0.8, age=0.4, actions={"jawOpen": 0.4})
    path = tmp_path_factory.mktemp("drawing") / "anna.json"
    write_sketch(path, draw_sketch(vertices, curves, canvas_camera(vertices, curves)))
    return path


def test_a_sketch_becomes_a_face_that_later_commands_take(run, drawing, tmp_path):
    out = tmp_path / "face.obj"
    result = run(COMMAND, drawing, "--out", out, "--model", "pca")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{out}: lines ")
    face = read_face(out.with_suffix(".npz"))
    assert face.camera is not None and face.latent.shape == (128,) and face.landmarks.shape == (81, 2)
    np.testing.assert_allclose(read_mesh(out).vertices, face.vertices, atol=1e-6)
    report = read_json(out.with_suffix(".json"))
    assert report["line_errors"]["all"] < 0.1 < report["line_errors_before"]["all"] * 2
    assert [stroke["curve"] for stroke in report["strokes"]].count("silhouette") == 1
    assert read_image(out.with_suffix(".png")).shape[1] > 2000
    edited = tmp_path / "edited.obj"
    line = ("edit-handle", out.with_suffix(".npz"), "--handle", "nose_tip=0,0,1%", "--model", "pca", "--no-picture")
    assert run(*line, "--out", edited).exit_code == 0


def test_many_sketches_in_one_call(run, drawing, tmp_path):
    bad = tmp_path / "empty.json"
    write_sketch(bad, Sketch())
    result = run(COMMAND, drawing, bad, "--out-dir", tmp_path / "faces", "--model", "pca", "--no-picture")
    assert result.exit_code == 1
    assert "1 of 2 failed" in result.stderr and "empty.json: expected a sketch" in result.stderr
    assert sorted(path.name for path in (tmp_path / "faces").iterdir()) == ["anna.json", "anna.npz", "anna.obj"]


def test_names_of_no_curve_are_told(run, drawing, tmp_path):
    sketch = read_sketch(drawing)
    renamed = {"mouth_upper": "mouth_uper", "silhouette": "hat"}
    strokes = [replace(stroke, curve=renamed.get(stroke.curve, stroke.curve)) for stroke in sketch.strokes]
    write_sketch(tmp_path / "typo.json", sketch.with_strokes(strokes))
    words = ("--model", "pca", "--no-picture")
    result = run(COMMAND, tmp_path / "typo.json", "--out", tmp_path / "f.obj", *words)
    assert "typo.json: strokes are left" in result.stderr
    assert "hat, mouth_uper (mouth_upper?)" in result.stderr
    assert "are left" not in run(COMMAND, drawing, "--out", tmp_path / "g.obj", *words).stderr


def test_a_network_of_strokes_that_is_none_is_refused(refused, drawing, tmp_path):
    """Even where all strokes name their curves, so that nothing would be read."""
    line = refused(COMMAND, drawing, "--out", tmp_path / "f.obj", "--strokes", asset_path("sketch.safetensors"))
    assert "expected a stroke network" in line


def test_following_is_a_share(run, drawing, tmp_path):
    result = run(COMMAND, drawing, "--out", tmp_path / "f.obj", "--follow", 1.5)
    assert result.exit_code == 2 and "1.5" in result.stderr


@pytest.mark.parametrize(
    ("strokes", "message"),
    [
        ([], "a sketch of lines, found 0 strokes"),
        ([Stroke(np.full((1, 2), 99.0))], "a sketch of lines, found 1 strokes"),
        ([Stroke(np.array([[-900.0, -900], [-800, -900]]), curve="brow_left")], "lines on the canvas"),
        ([Stroke(np.array([[20.0, 20], [60, 24]]), curve="brow_left")], "lines of the curves of a face"),
    ],
)
def test_what_is_no_face_is_refused(refused, tmp_path, strokes, message):
    path = tmp_path / "bad.json"
    write_sketch(path, Sketch(tuple(strokes)))
    line = refused(COMMAND, path, "--out", tmp_path / "f.obj", "--model", "pca")
    assert f"bad.json: expected {message}" in line
