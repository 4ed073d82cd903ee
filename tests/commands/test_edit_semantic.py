import dataclasses

import numpy as np
import pytest

from caricli.io.directions import read_directions, write_directions
from caricli.io.face import read_face, write_face
from caricli.io.image import read_image
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.strict_json import read_json
from caricli.methods.faces.encode_face import encode_face
from caricli.store.models import load_model
from caricli.structures import Camera, Face, Mesh

pytestmark = pytest.mark.usefixtures("small_pictures")


@pytest.fixture(params=["pca", "kernel", "intrinsic"])
def known(request, models, directions):
    """Options that name a small model and its directions."""
    return ("--model", models[request.param], "--directions", directions[request.param])


@pytest.fixture
def pca(models, directions):
    return ("--model", models["pca"], "--directions", directions["pca"])


def own_latent(vertices, model):
    return encode_face(Face(model.template.with_vertices(vertices)), model).latent


def test_a_strength_and_its_opposite_bring_the_face_back(run, smile, known, tmp_path):
    there, back = tmp_path / "new" / "there.obj", tmp_path / "new" / "back.obj"
    result = run("edit-semantic", smile, "--label", "BigNose=2", "--out", there, *known)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{there}: BigNose=2, prior ") and "smile.obj: had no latent" in result.stderr
    names = sorted(path.name for path in there.parent.iterdir())
    assert names == ["there.json", "there.npz", "there.obj", "there.png"]
    start, moved, model = read_obj(smile).vertices, read_face(there.with_suffix(".npz")), load_model(known[1])
    np.testing.assert_allclose(read_obj(there).vertices, moved.vertices, atol=1e-7)
    assert np.abs(moved.vertices - start).max() > 1e-3
    whitened = model.prior.whiten(moved.latent) - model.prior.whiten(own_latent(start, model))
    np.testing.assert_allclose(whitened, [2, 0, 0, 0, 0], atol=1e-4)
    report = read_json(there.with_suffix(".json"))
    assert report["labels"] == {"BigNose": 2} and report["keep"] == [] and report["model_id"] == model.model_id
    assert report["after"]["attributes"]["BigNose"] != report["before"]["attributes"]["BigNose"]
    assert set(report["inputs"]) == {str(smile), str(known[3])}
    result = run("edit-semantic", there.with_suffix(".npz"), "--label", "BigNose=-2", "--out", back, *known)
    assert result.exit_code == 0 and result.stderr == "", result.output
    assert np.abs(read_obj(back).vertices - start).max() < 1e-5 * model.template.height
    np.testing.assert_array_equal(read_face(back.with_suffix(".npz")).residual, moved.residual)


def test_camera_and_landmarks_stay(run, smile, models, pca, tmp_path):
    assert run("encode", smile, "--out", tmp_path / "a.npz", "--model", models["pca"]).exit_code == 0
    camera = Camera(900.0, np.diag([1.0, -1, -1]), np.array([3.0, 4]))
    marks = np.arange(136.0).reshape(68, 2)
    face = dataclasses.replace(read_face(tmp_path / "a.npz"), camera=camera, landmarks=marks)
    write_face(tmp_path / "a.npz", face)
    result = run("edit-semantic", tmp_path / "a.npz", "--label", "Smile=0", "--out", tmp_path / "b.obj", *pca)
    assert result.exit_code == 0, result.output
    edited = read_face(tmp_path / "b.npz")
    for key in ("scale", "rotation", "translation"):
        np.testing.assert_array_equal(getattr(edited.camera, key), getattr(camera, key))
    np.testing.assert_array_equal(edited.landmarks, marks)
    np.testing.assert_allclose(edited.vertices, face.vertices, atol=1e-6)


def test_what_is_kept_does_not_move(run, smile, models, pca, tmp_path):
    # Of the small directions BigNose has its gradient along itself, Smile has BigNose's.
    out = tmp_path / "a.obj"
    options = ("--label", "Smile=1", "--label", "Caricature=-1", "--keep", "BigNose")
    assert run("edit-semantic", smile, *options, "--out", out, *pca).exit_code == 0
    model, face = load_model(models["pca"]), read_face(tmp_path / "a.npz")
    start = own_latent(read_obj(smile).vertices, model)
    step = model.prior.whiten(face.latent) - model.prior.whiten(start)
    np.testing.assert_allclose(step, [0, 1, -1, 0, 0], atol=1e-4)


def test_film_strip_and_finer_mesh(run, smile, pca, tmp_path):
    options = ("--label", "BigNose=1", "--out", tmp_path / "a.obj", *pca)
    assert run("edit-semantic", smile, *options).exit_code == 0
    pair, coarse = read_image(tmp_path / "a.png"), read_obj(tmp_path / "a.obj")
    assert "exists" in run("edit-semantic", smile, *options).stderr
    assert run("edit-semantic", smile, *options, "--steps", 5, "--subdivide", 1, "--overwrite").exit_code == 0
    assert read_image(tmp_path / "a.png").shape[1] > 2 * pair.shape[1]
    fine = read_obj(tmp_path / "a.obj").vertices
    np.testing.assert_allclose(fine[: len(coarse.vertices)], coarse.vertices, atol=1e-7)


def test_the_labels_are_listed(run, pca):
    result = run("edit-semantic", "--list", *pca)
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert len(lines) == 4 and lines[1].split() == ["BigNose", "0.900", "4", "1.00"]
    bundled = run("edit-semantic", "--list")
    assert bundled.exit_code == 0 and len(bundled.stdout.splitlines()) > 20


def test_bad_input_is_one_line_and_leaves_nothing(refused, smile, models, directions, pca, ball, run, tmp_path):
    out = tmp_path / "new" / "a.obj"

    def check(*words, face=smile, label="Smile=1", options=pca, code=1):
        said = refused("edit-semantic", face, "--label", label, "--out", out, *options, code=code)
        assert all(word in said for word in words), said

    check("label 'Smlie'", "did you mean 'Smile'", label="Smlie=1")
    check("label 'nose'", "did you mean", options=(*pca, "--keep", "nose"))
    for text in ("Smile", "Smile=", "Smile=much", "Smile=nan", "Smile=-inf"):
        check("NAME=STRENGTH", label=text, code=2)
    check("label ''", label="=1", code=2)
    check("strength of at most", label="Smile=1e9")
    check("every label once", options=(*pca, "--label", "Smile=2"), code=2)
    check("cannot change while Smile is kept", options=(*pca, "--keep", "Smile"))
    check("none.npz", face=tmp_path / "none.npz")
    check("none.npz", options=("--model", models["pca"], "--directions", tmp_path / "none.npz"))
    check("directions are of", options=("--model", models["pca"], "--directions", directions["kernel"]))
    check("bundled", "pca", "train semantic", options=("--model", models["pca"]))
    write_obj(tmp_path / "ball.obj", Mesh(*ball))
    check("topology", face=tmp_path / "ball.obj")
    other = tmp_path / "other.npz"
    assert run("encode", smile, "--out", other, "--model", models["kernel"]).exit_code == 0
    check("other.npz: its latent is of", face=other)
    check("expected directions with schema", options=("--model", models["pca"], "--directions", other))
    short = read_directions(directions["pca"])
    short = dataclasses.replace(short, normals=np.eye(3), gradients=np.eye(3), people=np.eye(3))
    write_directions(tmp_path / "short.npz", short)
    check("5 numbers, found 3", options=("--model", models["pca"], "--directions", tmp_path / "short.npz"))
    assert not out.parent.exists()


@pytest.mark.parametrize("missing", [["--label", "Smile=1"], ["--out", "x.obj"], []])
def test_wrong_usage_is_2(run, smile, pca, missing):
    result = run("edit-semantic", smile, *missing, *pca)
    assert result.exit_code == 2 and result.stdout == ""
