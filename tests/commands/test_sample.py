import numpy as np
import pytest

from caricli.io.face import read_face
from caricli.io.image import read_image
from caricli.io.meshes.obj import read_obj
from caricli.io.strict_json import read_json
from caricli.methods.faces.sample_faces import sample_faces
from caricli.store.models import load_model

NAMES = ["face-000.npz", "face-000.obj", "face-001.npz", "face-001.obj", "sheet.json", "sheet.png"]

pytestmark = pytest.mark.usefixtures("small_pictures")


@pytest.fixture(scope="module")
def sampled(run, models, tmp_path_factory):
    """The folder of two faces."""
    folder = tmp_path_factory.mktemp("sampled") / "faces"
    result = run("sample", "--out-dir", folder, "--count", 2, "--seed", 5, "--model", models["pca"])
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{folder}: 2 faces, 0 draws rejected, flipped triangles 0.0")
    return folder


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_faces_that_the_next_command_can_read(sampled, models, head):
    assert names(sampled) == NAMES
    model, report = load_model(models["pca"]), read_json(sampled / "sheet.json")
    for number in range(2):
        mesh, face = read_obj(sampled / f"face-00{number}.obj"), read_face(sampled / f"face-00{number}.npz")
        np.testing.assert_array_equal(mesh.polygons, head.polygons)
        np.testing.assert_array_equal(mesh.uv_polygons, head.uv_polygons)
        np.testing.assert_allclose(mesh.vertices, face.vertices, atol=1e-7)
        assert face.model_id == model.model_id == report["model_id"]
        np.testing.assert_allclose(model.prior.rms(face.latent), report["faces"][number]["prior_rms"], rtol=1e-5)
        if face.residual is None:
            np.testing.assert_allclose(model.decode(face.latent), face.vertices, atol=1e-6)
    first = read_face(sampled / "face-000.npz").latent
    assert np.abs(first - face.latent).max() > 0.1
    drawn = next(iter(sample_faces(model, np.random.default_rng(5), 1.0)))
    np.testing.assert_allclose(first, drawn.face.latent, atol=1e-6)


def test_the_report_and_the_sheet(sampled):
    report = read_json(sampled / "sheet.json")
    assert report["command"] == "sample" and report["seed"] == 5 and report["spread"] == 1.0
    assert report["subdivide"] == 0 and [row["face"] for row in report["faces"]] == ["face-000", "face-001"]
    for row in report["faces"]:
        assert row["flipped"] <= min(0.002, row["flipped_drawn"]) and row["rejected"] == 0
    picture = read_image(sampled / "sheet.png")
    assert picture.shape[1] > 2 * 48 and (picture < 205).any(-1).mean() > 0.2


def test_same_seed_same_bytes_and_more_faces_begin_alike(run, sampled, models, tmp_path):
    options = ("--seed", 5, "--model", models["pca"])
    assert run("sample", "--out-dir", tmp_path / "a", "--count", 2, *options).exit_code == 0
    for name in NAMES:
        assert (tmp_path / "a" / name).read_bytes() == (sampled / name).read_bytes(), name
    assert run("sample", "--out-dir", tmp_path / "b", "--count", 1, *options).exit_code == 0
    assert (tmp_path / "b" / "face-000.npz").read_bytes() == (sampled / "face-000.npz").read_bytes()


def test_subdivided_faces_begin_with_the_plain_ones(run, sampled, models, tmp_path):
    options = ("--count", 1, "--seed", 5, "--model", models["pca"], "--subdivide", 1)
    result = run("sample", "--out-dir", tmp_path, *options)
    assert result.exit_code == 0, result.output
    mesh, plain = read_obj(tmp_path / "face-000.obj"), read_obj(sampled / "face-000.obj")
    assert len(mesh.polygons) == 4 * len(plain.polygons) and mesh.uv_polygons.max() < len(mesh.uvs)
    assert np.abs(mesh.vertices[: len(plain.vertices)] - plain.vertices).max() < 1e-6
    assert (tmp_path / "face-000.npz").read_bytes() == (sampled / "face-000.npz").read_bytes()
    assert read_json(tmp_path / "sheet.json")["subdivide"] == 1
    assert (read_image(tmp_path / "sheet.png") < 205).any(-1).mean() > 0.2


def test_a_spread_of_0_is_the_mean_face(run, models, tmp_path):
    assert run("sample", "--out-dir", tmp_path, "--count", 1, "--spread", 0, "--model", models["pca"]).exit_code == 0
    model = load_model(models["pca"])
    np.testing.assert_allclose(read_face(tmp_path / "face-000.npz").latent, model.prior.mean, atol=1e-7)


def test_bad_input_is_one_line_and_leaves_nothing(refused, models, tmp_path):
    out, model = ("--out-dir", tmp_path / "new", "--count", 1), ("--model", models["pca"])
    said = refused("sample", *out, *model, "--subdivide", 4)
    assert "memory cap" in said and "1000000" in said
    bad = tmp_path / "bad.safetensors"
    bad.write_bytes(models["pca"].read_bytes()[:-100])
    assert "bad.safetensors" in refused("sample", *out, "--model", bad)
    assert names(tmp_path) == ["bad.safetensors"]


def test_a_model_that_only_tears_leaves_nothing(refused, models, tmp_path, monkeypatch):
    from caricli.methods.faces import sample_faces

    monkeypatch.setattr(sample_faces, "TRIES", 2)
    monkeypatch.setattr(sample_faces, "flipped_triangles", lambda vertices, gradients: np.ones(10))
    said = refused("sample", "--out-dir", tmp_path / "new", "--model", models["pca"])
    assert "flipped triangles" in said and "spread" in said
    assert names(tmp_path) == []


def test_what_exists_stays(refused, sampled, models):
    before = {name: (sampled / name).read_bytes() for name in NAMES}
    assert "--overwrite" in refused("sample", "--out-dir", sampled, "--count", 1, "--model", models["pca"])
    assert {name: (sampled / name).read_bytes() for name in names(sampled)} == before


@pytest.mark.parametrize(
    "arguments", [[], ["--count", "0"], ["--spread", "-1"], ["--subdivide", "5"], ["--seed", "-1"], ["--spread", "nan"]]
)
def test_wrong_usage_is_2(run, tmp_path, arguments):
    result = run("sample", *(["--out-dir", tmp_path / "x", *arguments] if arguments else []))
    assert result.exit_code == 2 and result.stdout == "" and names(tmp_path) == []
