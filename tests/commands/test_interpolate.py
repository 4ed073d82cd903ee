import numpy as np
import pytest

from caricli.io.face import read_face, write_face
from caricli.io.image import read_image
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.strict_json import read_json
from caricli.structures import Face, Mesh

pytestmark = pytest.mark.usefixtures("small_pictures")


@pytest.fixture(scope="module")
def ends(run, head, models, tmp_path_factory):
    """An OBJ, and the NPZ of another face encoded by the pca model."""
    folder = tmp_path_factory.mktemp("ends")
    for name, more in (("a", {"gender": 0.1}), ("b", {"age": 0.9, "actions": {"jawOpen": 0.5}})):
        mesh = Mesh(head.evaluate(**more), head.polygons, head.uvs, head.uv_polygons)
        write_obj(folder / f"{name}.obj", mesh)
    encoded = run("encode", folder / "b.obj", "--out", folder / "b.npz", "--model", models["pca"])
    assert encoded.exit_code == 0, encoded.output
    return folder / "a.obj", folder / "b.npz"


def test_from_a_mesh_to_an_encoded_face(run, ends, models, tmp_path):
    out = tmp_path / "between"
    result = run("interpolate", *ends, "--steps", 3, "--out-dir", out, "--model", models["pca"])
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{out}: 3 faces, flipped triangles at most 0.0")
    # Only the mesh had to be encoded, and that is said.
    assert result.stderr.startswith(f"{ends[0]}: had no latent; encoded by the model ")
    assert result.stderr.count("\n") == 1 and "mm (" in result.stderr
    suffixes = [f"step-00{k}.{suffix}" for k in range(3) for suffix in ("npz", "obj")]
    assert sorted(path.name for path in out.iterdir()) == [*suffixes, "strip.json", "strip.png"]
    faces = [read_face(out / f"step-00{k}.npz") for k in range(3)]
    for k, end in ((0, ends[0]), (2, ends[1])):
        np.testing.assert_array_equal(faces[k].vertices.astype(np.float32), read_face(end).vertices.astype(np.float32))
        np.testing.assert_allclose(read_obj(out / f"step-00{k}.obj").vertices, read_face(end).vertices, atol=1e-7)
    np.testing.assert_allclose(faces[1].latent, (faces[0].latent + faces[2].latent) / 2, atol=1e-6)
    assert faces[1].model_id == read_face(ends[1]).model_id and faces[1].residual is not None
    report = read_json(out / "strip.json")
    assert set(report["inputs"]) == {str(end) for end in ends} and report["model_id"] == faces[1].model_id
    assert [row["weight"] for row in report["faces"]] == [0, 0.5, 1]
    strip = read_image(out / "strip.png")
    assert strip.shape[1] > 3 * 48 and strip.shape[0] > 2 * 48 and (strip < 205).any(-1).mean() > 0.2


def test_the_strip_shows_some_of_many_steps_and_its_faces_can_be_taken_on(run, ends, models, tmp_path, monkeypatch):
    monkeypatch.setattr("caricli.commands.interpolate.DRAWN", 3)
    model = ("--model", models["pca"])
    assert run("interpolate", *ends, "--steps", 5, "--out-dir", tmp_path / "one", *model).exit_code == 0
    assert 3 * 48 < read_image(tmp_path / "one" / "strip.png").shape[1] < 4 * 48
    halves = tmp_path / "one" / "step-001.npz", tmp_path / "one" / "step-003.npz"
    result = run("interpolate", *halves, "--steps", 2, "--out-dir", tmp_path / "two", *model)
    assert result.exit_code == 0 and result.stderr == ""


def test_subdivided_steps_begin_with_the_plain_ones(run, ends, models, tmp_path):
    options = ("--steps", 2, "--out-dir", tmp_path, "--model", models["pca"], "--subdivide", 1)
    assert run("interpolate", *ends, *options).exit_code == 0
    mesh, face = read_obj(tmp_path / "step-001.obj"), read_face(tmp_path / "step-001.npz")
    assert face.vertices.shape == (4200, 3) and len(mesh.vertices) == 16_755
    assert np.abs(mesh.vertices[:4200] - face.vertices).max() < 1e-6
    assert read_json(tmp_path / "strip.json")["subdivide"] == 1


def test_a_latent_of_another_model_is_refused_with_what_to_do(run, refused, ends, models, tmp_path):
    out = ("--out-dir", tmp_path / "new")
    face = read_face(ends[1])
    said = refused("interpolate", *ends, *out, "--model", models["intrinsic"])
    assert f"b.npz: its latent is of the model {face.model_id[:12]}" in said
    assert f"caricli encode {ends[1]} --model MODEL --out" in said
    # Bundled models are called by their names.
    assert run("encode", ends[0], "--out", tmp_path / "a.npz", "--model", "intrinsic").exit_code == 0
    said = refused("interpolate", tmp_path / "a.npz", ends[0], *out, "--model", "pca")
    assert "latent is of the bundled intrinsic model, not of the bundled pca model" in said
    assert "--model intrinsic" in said and "--model pca --out" in said
    assert not (tmp_path / "new").exists()


def test_a_latent_of_another_length_is_refused(refused, ends, models, tmp_path):
    face = read_face(ends[1])
    write_face(tmp_path / "x.npz", Face(face.mesh, latent=np.ones(9), model_id=face.model_id))
    said = refused("interpolate", ends[0], tmp_path / "x.npz", "--out-dir", tmp_path / "new", "--model", models["pca"])
    assert "x.npz" in said and "5 numbers, found 9" in said


def test_a_latent_of_nobody_is_encoded_again(run, ends, models, tmp_path):
    face = read_face(ends[1])
    write_face(tmp_path / "x.npz", Face(face.mesh, latent=np.ones(5)))
    options = ("--steps", 2, "--out-dir", tmp_path / "out", "--model", models["pca"])
    result = run("interpolate", tmp_path / "x.npz", ends[1], *options)
    assert result.exit_code == 0 and "x.npz: had no latent" in result.stderr
    np.testing.assert_allclose(read_face(tmp_path / "out" / "step-000.npz").latent, face.latent, atol=1e-4)


def test_bad_input_is_one_line_and_leaves_nothing(refused, ends, ball, models, tmp_path):
    out = ("--out-dir", tmp_path / "new", "--model", models["pca"])
    write_obj(tmp_path / "ball.obj", Mesh(*ball))
    said = refused("interpolate", ends[0], tmp_path / "ball.obj", *out)
    assert "ball.obj" in said and "topology" in said and "300 vertices" in said
    assert "none.npz" in refused("interpolate", ends[0], tmp_path / "none.npz", *out)
    assert "memory cap" in refused("interpolate", *ends, *out, "--subdivide", 4)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("arguments", [["a.obj"], ["a.obj", "b.obj", "--steps", "1"], ["a.obj", "b.obj", "c.obj"]])
def test_wrong_usage_is_2(run, tmp_path, arguments):
    result = run("interpolate", *arguments, "--out-dir", tmp_path / "x")
    assert result.exit_code == 2 and result.stdout == ""
