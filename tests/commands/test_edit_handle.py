import numpy as np
import pytest
from PIL import Image

from caricli.errors import InputError
from caricli.io.face import read_face, write_face
from caricli.io.meshes.mesh import read_mesh, write_mesh
from caricli.io.strict_json import read_json, write_json
from caricli.structures import Face, Mesh


@pytest.fixture(scope="module", autouse=True)
def small():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.commands.edit_handle.SIZE", 48)
        yield


@pytest.fixture(scope="module")
def face(run, tmp_path_factory):
    """A random face of the default model."""
    folder = tmp_path_factory.mktemp("faces")
    assert run("sample", "--out-dir", folder, "--count", 1).exit_code == 0
    return folder / "face-000.npz"


def test_the_edit_is_written_with_a_report_and_a_picture(run, face, tmp_path):
    out = tmp_path / "nose.obj"
    result = run("edit-handle", face, "--handle", "nose_tip=0,0,5%", "--out", out, "--baseline", "arap")
    assert result.exit_code == 0, result.output
    assert "reached 100 %" in result.stdout
    before, after, mesh = read_face(face), read_face(out.with_suffix(".npz")), read_face(out)
    np.testing.assert_allclose(mesh.vertices, after.vertices, atol=1e-6)
    report = read_json(out.with_suffix(".json"))
    handle = report["handles"][0]
    moved = (after.vertices - before.vertices)[handle["vertex"]]
    np.testing.assert_allclose(moved, handle["achieved"], atol=1e-6)
    assert handle["reached"] == pytest.approx(1, abs=0.01) and handle["where"] == "nose_tip"
    assert report["energy_elsewhere"] < 0.15
    assert report["flipped_triangles"]["after"] <= report["flipped_triangles"]["before"]
    assert Image.open(out.with_suffix(".png")).size[1] > 3 * 48


def test_handles_come_from_a_file_too_and_a_strip_is_drawn(run, face, tmp_path):
    asked, out = tmp_path / "handles.json", tmp_path / "ears.obj"
    write_json(asked, {"ear_left": ["5%", 0, 0]})
    options = ("--handles", asked, "--pin", "chin", "--symmetric", "--steps", 3, "--norm", "l1")
    result = run("edit-handle", face, "--out", out, *options)
    assert result.exit_code == 0, result.output
    rows = read_json(out.with_suffix(".json"))["handles"]
    assert [row["where"] for row in rows] == ["ear_left", "ear_left mirrored", "chin"]
    assert rows[0]["achieved"][0] > 0 > rows[1]["achieved"][0]
    assert "reached" not in rows[2] and np.abs(rows[2]["achieved"]).max() < 1e-3


@pytest.mark.parametrize("command", ["reconstruct-from-landmarks", "fit-morphable"])
def test_a_reconstructed_face_is_edited_without_a_word_about_models(run, refused, marks, tmp_path, command):
    made = tmp_path / "made.npz"
    assert run(command, marks, "--out", made.with_suffix(".obj")).exit_code == 0
    result = run("edit-handle", made, "--handle", "chin=0,-3%,0", "--out", tmp_path / "chin.obj")
    assert result.exit_code == 0 and result.stderr == ""
    edited, given = read_face(tmp_path / "chin.npz"), read_face(made)
    np.testing.assert_array_equal(edited.camera.rotation, given.camera.rotation)
    asked = ("--handle", "chin=0,-3%,0", "--out", tmp_path / "no.obj", "--model", "pca")
    assert "its latent is of the bundled" in refused("edit-handle", made, *asked)
    assert not list(tmp_path.glob("no.*"))


def test_shares_are_of_the_face_that_is_edited(run, face, tmp_path):
    given = read_face(face)
    large = tmp_path / "large.obj"
    write_mesh(large, given.mesh.with_vertices(1.2 * given.vertices))
    for path, height in ((face, given.mesh.height), (large, 1.2 * given.mesh.height)):
        out = tmp_path / "out" / f"{path.stem}.ply"
        result = run("edit-handle", path, "--handle", "nose_tip=0,0,5%", "--out", out)
        assert result.exit_code == 0, result.output
        requested = read_json(out.with_suffix(".json"))["handles"][0]["requested"]
        np.testing.assert_allclose(requested, [0, 0, 0.05 * height], rtol=1e-6)
        # The mesh has the format that its name asks for.
        mesh = read_mesh(out)
        np.testing.assert_allclose(mesh.vertices, read_face(out.with_suffix(".npz")).vertices, atol=1e-6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--handle", "nose_tpi=0,0,5%"], "did you mean nose_tip"),
        (["--handle", "nose_tip"], "expected WHERE=DX,DY,DZ"),
        (["--handle", "nose_tip=0,0"], "expected WHERE=DX,DY,DZ"),
        (["--handle", "nose_tip=0,0,nan"], "expected metres or a share"),
        (["--handle", "nose_tip=0,0,9"], "half the head's height"),
        (["--handle", "nose_tip=0,0,1e-200"], "a handle that moves"),
        (["--handle", "9999=0,0,1%"], "vertex from 0 to 4199"),
        (["--handle", "l99=0,0,1%"], "l0 to l80"),
        (["--handle", "chin=0,1%,0", "--handle", "l8=0,2%,0"], "contradict"),
        (["--pin", "chin"], "at least one --handle"),
        ([], "at least one --handle"),
        (
            ["--handle", "chin=0,0,1%", "--steps", "3", "--baseline", "arap"],
            "--baseline is drawn beside before and after",
        ),
    ],
)
def test_bad_handles_are_one_line_and_leave_nothing(refused, face, tmp_path, options, said):
    code = 2 if "WHERE" in said or said.startswith("--baseline") or "--handle" in said else 1
    assert said in refused("edit-handle", face, "--out", tmp_path / "x.obj", *options, code=code)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "asked"),
    [([], (2, False)), (["--norm", "l1"], (1, False)), (["--no-intersections"], (2, True))],
)
def test_norm_and_intersections_are_as_asked(refused, face, tmp_path, monkeypatch, options, asked):
    def tell(_face, _model, _handles, settings, avoid):
        raise InputError(f"asked for {(settings.norm, avoid)}")

    monkeypatch.setattr("caricli.methods.edit.edit_handles.edit_handles", tell)
    out = ("--handle", "chin=0,1%,0", "--out", tmp_path / "x.obj")
    assert f"asked for {asked}" in refused("edit-handle", face, *out, *options)


def test_bad_faces_and_files_are_refused(refused, face, tmp_path):
    good, out = read_face(face), ("--handle", "chin=0,1%,0", "--out", tmp_path / "x.obj")
    strange = tmp_path / "strange.npz"
    write_face(strange, Face(good.mesh, latent=good.latent, model_id="0" * 64))
    assert "its latent is of the model 000000000000" in refused("edit-handle", strange, *out)
    write_face(strange, Face(Mesh(good.vertices, good.faces[:-1])))
    assert "expected the topology of the model" in refused("edit-handle", strange, *out)
    assert "missing.npz" in refused("edit-handle", tmp_path / "missing.npz", *out)
    listed = tmp_path / "list.json"
    write_json(listed, [1, 2])
    assert "JSON object" in refused("edit-handle", face, *out, "--handles", listed)
    assert not list(tmp_path.glob("x.*"))
