import numpy as np
import pytest

from caricli.io.face import read_face
from caricli.io.image import write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.obj import read_obj
from caricli.io.strict_json import read_json
from caricli.store.faces import load_face
from caricli.store.models import load_model
from caricli.structures import Landmarks

COMMAND = "fit-morphable"


@pytest.fixture(scope="module")
def fitted(run, points, tmp_path_factory):
    """(folder with face.*, landmark file)."""
    folder = tmp_path_factory.mktemp("fitted")
    marks = folder / "marks.json"
    write_landmarks(marks, Landmarks(points[:68], (400, 400)))
    result = run(COMMAND, marks, "--out", folder / "out" / "face.obj")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{folder / 'out' / 'face.obj'}: NME 0.")
    return folder / "out", marks


def test_four_files_that_agree_with_each_other(fitted, head):
    folder, _ = fitted
    assert sorted(path.name for path in folder.iterdir()) == ["face.json", "face.npz", "face.obj", "face.png"]
    mesh, face, report = read_obj(folder / "face.obj"), read_face(folder / "face.npz"), read_json(folder / "face.json")
    model = load_model(kind="morphable")
    np.testing.assert_array_equal(mesh.polygons, head.polygons)
    np.testing.assert_allclose(face.vertices, mesh.vertices, atol=1e-7)
    assert face.latent.shape == (144,) and face.residual is None and face.model_id == model.model_id
    np.testing.assert_allclose(model.decode(face.latent), face.vertices, atol=1e-5)
    projected = face.camera.scale * face.vertices @ face.camera.rotation[:2].T + face.camera.translation
    np.testing.assert_allclose(projected[report["anchors"]], face.landmarks, atol=1e-3)
    assert report["command"] == COMMAND and report["weights"] == [1.2, 1.0] and report["expression_only"] is False


def test_later_commands_go_on_from_the_face(run, fitted, tmp_path):
    folder, _ = fitted
    result = run("encode", folder / "face.npz", "--model", "morphable", "--out", tmp_path / "again.npz")
    assert result.exit_code == 0, result.output
    face, again = read_face(folder / "face.npz"), read_face(tmp_path / "again.npz")
    gaps = load_model(kind="morphable").decode(again.latent) - face.vertices
    assert np.linalg.norm(gaps, axis=1).mean() < 5e-4
    result = run("interpolate", folder / "face.npz", folder / "face.npz", "--model", "morphable",
                 "--out-dir", tmp_path / "between", "--steps", 3)  # fmt: skip
    assert result.exit_code == 0, result.output
    between = [read_face(path) for path in sorted((tmp_path / "between").glob("*.npz"))]
    assert len(between) == 3
    for each in between:
        np.testing.assert_allclose(each.vertices, face.vertices, atol=1e-5)


def test_expression_only_keeps_the_identity(run, fitted, tmp_path):
    folder, marks = fitted
    model, first = load_model(kind="morphable"), read_face(folder / "face.npz").latent
    for name, options in (("mean", []), ("own", ["--identity", folder / "face.npz"])):
        out = tmp_path / f"{name}.obj"
        result = run(COMMAND, marks, "--out", out, "--expression-only", *options)
        assert result.exit_code == 0, result.output
        who = model.parts(read_face(out.with_suffix(".npz")).latent)[0]
        np.testing.assert_allclose(who, model.parts(first)[0] if options else 0 * who, atol=1e-5)
    assert read_json(tmp_path / "own.json")["nme"] < read_json(tmp_path / "mean.json")["nme"]


def test_larger_weights_stay_nearer_to_the_mean(run, fitted, tmp_path):
    folder, marks = fitted
    assert run(COMMAND, marks, "--out", tmp_path / "f.obj", "--weight", 60, 50).exit_code == 0
    report, before = read_json(tmp_path / "f.json"), read_json(folder / "face.json")
    assert report["prior_rms"] < 0.5 * before["prior_rms"] and report["nme"] > before["nme"]


def test_colours_are_fitted_drawn_and_written(run, refused, fitted, tmp_path):
    _, marks = fitted
    photo = tmp_path / "photo.png"
    write_png(photo, np.full((400, 400, 3), [200, 150, 120], np.uint8))
    result = run(COMMAND, marks, "--image", photo, "--photometric", "--out", tmp_path / "f.glb", "--no-picture")
    assert result.exit_code == 0 and "colours" in result.stdout, result.output
    report, face = read_json(tmp_path / "f.json"), load_face(tmp_path / "f.npz", load_model(kind="morphable"))
    assert sum(map(len, report["coefficients"].values())) == 239
    assert report["photometric"]["after"] < report["photometric"]["before"]
    # A picture of one colour is a face of about that colour.
    assert np.abs(np.median(face.pictures.skin, (0, 1)) - [200, 150, 120]).max() < 60
    told = refused(COMMAND, marks, "--photometric", "--out", tmp_path / "none.obj")
    assert f"{marks.name}: expected a picture" in told


def test_a_bad_file_does_not_stop_the_others(run, fitted, tmp_path):
    _, marks = fitted
    bad = tmp_path / "bad.json"
    bad.write_text("{}")
    result = run(COMMAND, marks, bad, "--out-dir", tmp_path / "out")
    assert result.exit_code == 1 and "bad" in result.stderr
    assert sorted(path.stem for path in (tmp_path / "out").glob("*.obj")) == ["marks"]


def test_bad_input_is_one_line_and_leaves_nothing(run, refused, fitted, tmp_path):
    _, marks = fitted
    out = tmp_path / "f.obj"
    assert "missing" in refused(COMMAND, tmp_path / "missing.json", "--out", out)
    assert "morphable" in refused(COMMAND, marks, "--out", out, "--model", "pca")
    said = refused(COMMAND, marks, "--out", out, "--expression-only", "--identity", tmp_path / "none.npz")
    assert "none.npz" in said
    for options in (["--identity", "f.npz"], ["--weight", 0, 1], ["--weight", "nan", 1]):
        assert run(COMMAND, marks, "--out", out, *options).exit_code == 2
    assert list(tmp_path.iterdir()) == []
