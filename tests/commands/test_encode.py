import numpy as np
import pytest

from caricli.io.face import read_face, write_face
from caricli.io.image import read_image
from caricli.io.meshes.obj import write_obj
from caricli.io.strict_json import read_json
from caricli.structures import Camera, Face, Mesh

pytestmark = pytest.mark.usefixtures("small_pictures")


@pytest.fixture
def foreign(ball, tmp_path):
    path = tmp_path / "ball.obj"
    write_obj(path, Mesh(*ball))
    return path


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("kind", ["pca", "intrinsic"])
def test_the_latent_and_what_is_left_over_bring_the_mesh_back(run, smile, models, kind, tmp_path):
    from caricli.methods.faces.encode_face import decode_face
    from caricli.store.models import load_model

    out = tmp_path / "out" / "smile.npz"
    result = run("encode", smile, "--out", out, "--model", models[kind])
    assert result.exit_code == 0, result.output
    assert names(out.parent) == ["smile.json", "smile.npz", "smile.png"]
    given, face, report = read_face(smile), read_face(out), read_json(out.with_suffix(".json"))
    np.testing.assert_allclose(face.vertices, given.vertices, atol=1e-7)
    for name in ("polygons", "uvs", "uv_polygons"):
        np.testing.assert_allclose(getattr(face.mesh, name), getattr(given.mesh, name))
    model = load_model(models[kind])
    assert face.model_id == report["model_id"] == model.model_id
    back = decode_face(face, model)
    centred = [shape - shape.mean(0) for shape in (back.vertices, face.vertices)]
    assert np.abs(centred[0] - centred[1]).max() < 1e-6
    # The head stands somewhere else, which is no shape.
    place = (face.vertices - model.template.vertices).mean(0)
    distance = 1000 * np.linalg.norm(model.decode(face.latent) + place - face.vertices, axis=1).mean()
    np.testing.assert_allclose(report["shape_error"]["millimetres"], distance, rtol=1e-4)
    assert report["inputs"].keys() == {str(smile)} and report["prior_rms"] > 0
    shown = f"{out}: shape error {distance:.3f} mm ({report['shape_error']['percent']:.3f} %)"
    assert result.stdout.startswith(shown)
    picture = read_image(out.with_suffix(".png"))
    assert picture.shape[0] > 3 * 48 and (picture < 205).any(-1).mean() > 0.2


def test_the_file_has_the_name_that_was_typed(run, smile, models, tmp_path):
    result = run("encode", smile, "--out", tmp_path / "out" / "S.NPZ", "--model", models["pca"], "--no-picture")
    assert result.exit_code == 0, result.output
    assert names(tmp_path / "out") == ["S.NPZ", "S.json"] and "S.NPZ: " in result.stdout


def test_many_faces_and_a_bad_one(run, smile, foreign, models, tmp_path):
    result = run("encode", smile, foreign, "--out-dir", tmp_path / "out", "--model", models["pca"])
    assert result.exit_code == 1
    assert names(tmp_path / "out") == ["smile.json", "smile.npz", "smile.png"]
    assert "ball.obj" in result.stderr and "1 of 2 failed" in result.stderr


def test_a_face_keeps_its_camera_and_gets_another_latent(run, smile, models, tmp_path):
    given = read_face(smile)
    camera = Camera(900.0, np.diag([1.0, -1, -1]), np.ones(2))
    face = Face(Mesh(given.vertices, given.faces), camera, np.zeros((68, 2)), latent=np.ones(3), model_id="0" * 64)
    write_face(tmp_path / "old.npz", face)
    assert run("encode", tmp_path / "old.npz", "--out", tmp_path / "new.npz", "--model", models["pca"]).exit_code == 0
    face = read_face(tmp_path / "new.npz")
    assert face.latent.shape == (5,) and face.camera.scale == 900.0 and face.landmarks.shape == (68, 2)


def test_the_same_bytes_again(run, smile, models, tmp_path):
    for name in ("a", "b"):
        assert run("encode", smile, "--out", tmp_path / f"{name}.npz", "--model", models["pca"]).exit_code == 0
    for suffix in (".npz", ".json", ".png"):
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_bundled_models_have_names(run, refused, smile, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("encode", smile, "--out", "smile.npz", "--model", "intrinsic").exit_code == 0
    assert read_face(tmp_path / "smile.npz").latent.shape == (128,)
    assert "unheard" in refused("encode", smile, "--out", "other.npz", "--model", "unheard")
    # A file of that name goes first.
    (tmp_path / "pca").write_text("mine")
    assert refused("encode", smile, "--out", "other.npz", "--model", "pca").startswith("caricli: error: pca: ")


def scaled(path, smile, factor):
    face = read_face(smile)
    write_obj(path, face.mesh.with_vertices(face.vertices * factor))


BAD = {
    "missing": (lambda path, smile: None, "no such file"),
    "empty": (lambda path, smile: path.write_bytes(b""), "empty"),
    "a web page": (lambda path, smile: path.write_bytes(b"<html></html>"), "HTML"),
    "not a number": (lambda path, smile: path.write_text("v 1 2 nan\nv 1 0 0\nv 0 0 0\nf 1 2 3\n"), "line 1"),
    "centimetres": (lambda path, smile: scaled(path, smile, 100), "m high, found"),
    "a point": (lambda path, smile: scaled(path, smile, 0), "all of them in one place"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_faces_are_one_line_and_leave_nothing(refused, smile, models, tmp_path, case):
    make, word = BAD[case]
    make(tmp_path / "x.obj", smile)
    said = refused("encode", tmp_path / "x.obj", "--out", tmp_path / "new" / "x.npz", "--model", models["pca"])
    assert "x.obj" in said and word in said
    assert not (tmp_path / "new").exists()


def test_another_topology_is_refused_with_both(refused, foreign, models, tmp_path):
    said = refused("encode", foreign, "--out", tmp_path / "new" / "x.npz", "--model", models["pca"])
    assert "4200 vertices" in said and "300 vertices" in said and "topology" in said
    assert not (tmp_path / "new").exists()


def test_nothing_is_overwritten(run, refused, smile, models, tmp_path):
    out, model = tmp_path / "smile.npz", ("--model", models["pca"])
    (tmp_path / "smile.json").write_text("mine")
    assert "--overwrite" in refused("encode", smile, "--out", out, *model)
    assert names(tmp_path) == ["smile.json"]
    assert run("encode", smile, "--out", out, *model, "--overwrite").exit_code == 0
    assert "input" in refused("encode", out, "--out", out, *model, "--overwrite")


@pytest.mark.parametrize(
    "arguments", [[], ["a.obj"], ["a.obj", "--out", "x.obj"], ["a.obj", "b.obj", "--out", "x.npz"],
                  ["a.obj", "a.npz", "--out-dir", "y"], ["a.obj", "--out", "x.npz", "--out-dir", "y"]],
)  # fmt: skip
def test_wrong_usage_is_2(run, arguments):
    result = run("encode", *arguments)
    assert result.exit_code == 2 and result.stdout == ""
