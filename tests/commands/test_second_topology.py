"""Meshes of a user's own, from OBJ files to OBJ files."""

import numpy as np
import pytest

from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.alignment.similarity import similarity
from caricli.io.face import read_face
from caricli.io.image import read_image
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.obj import read_obj
from caricli.io.strict_json import read_json
from caricli.structures import Landmarks


@pytest.fixture(scope="module")
def trained(run, eggs, tmp_path_factory):
    """The imported dataset and the models of the eggs, all made by commands."""
    folder = tmp_path_factory.mktemp("own")
    data = folder / "dataset"
    result = run("dataset", "import", eggs, data, "--annotation", eggs.parent / "annotation.json")
    assert result.exit_code == 0 and result.stdout.startswith(
        f"{data}: 12 meshes, people 12, expressions 1, 0.240 m high, taken as given in m, "
    ), result.output
    for kind in ("pca", "intrinsic"):
        result = run("train", kind, "--data", data, "--out", folder / f"{kind}.safetensors")
        assert result.exit_code == 0, result.output
    return folder


def error(vertices, truth):
    scale, rotation, translation = similarity(vertices, truth)
    return np.linalg.norm(scale * vertices @ rotation.T + translation - truth, axis=1).mean()


@pytest.mark.parametrize("method", ["latent", "intrinsic"])
def test_a_held_out_shape_is_found_from_its_landmarks(run, trained, eggs, egg, tmp_path, method):
    truth = egg.shape(np.array([1.0, -0.8, 0.6, -1.1]))
    rotation = rotation_matrices(np.radians([[4.0, 12.0, -3.0]]))[0] @ np.diag([1.0, -1, -1])
    pixels = 2000 * truth[egg.annotation["ibug68"]] @ rotation[:2].T + [250, 300]
    write_landmarks(tmp_path / "held.txt", Landmarks(pixels))
    model = trained / ("pca.safetensors" if method == "latent" else "intrinsic.safetensors")
    out = tmp_path / "held.obj"
    options = ("--out", out, "--method", method, "--model", model)
    result = run("reconstruct-from-landmarks", tmp_path / "held.txt", *options)
    assert result.exit_code == 0, result.output
    written, first = read_obj(out), read_obj(eggs / "egg_00.obj")
    np.testing.assert_array_equal(written.polygons, first.polygons)
    np.testing.assert_array_equal(written.uv_polygons, first.uv_polygons)
    np.testing.assert_allclose(written.uvs, first.uvs, atol=1e-6)
    mean = np.mean([read_obj(path).vertices for path in sorted(eggs.glob("*.obj"))], axis=0)
    assert error(written.vertices, truth) < 0.4 * error(mean, truth)
    assert error(written.vertices, truth) < 0.01 * np.ptp(truth[:, 1])
    face = read_face(tmp_path / "held.npz")
    np.testing.assert_array_equal(face.mesh.polygons, first.polygons)
    np.testing.assert_allclose(face.camera.rotation, rotation, atol=0.1)
    assert read_json(tmp_path / "held.json")["nme"] < 1
    assert read_image(tmp_path / "held.png").std() > 10


def test_the_dataset_is_shown_and_the_models_are_evaluated(run, trained, tmp_path):
    result = run("dataset", "show", trained / "dataset", "-o", tmp_path / "sheet.png", "--faces", 4, "--size", 64)
    assert result.exit_code == 0, result.output
    assert "meshes 12, people 12, vertices 470" in result.stdout
    # The shapes were drawn from four fields, whose squares are not quite orthogonal.
    assert "components for 99 % of the variance: 4" in result.stdout
    assert read_image(tmp_path / "sheet.png").std() > 10
    models = [trained / "pca.safetensors", trained / "intrinsic.safetensors"]
    result = run("evaluate", "shape", *models, "--data", trained / "dataset", "-o", tmp_path / "errors.json")
    assert result.exit_code == 0, result.output
    errors = read_json(tmp_path / "errors.json")["models"]
    assert errors[str(models[0])]["test"]["percent"] < 0.05
    # The features of shapes that are linear in four numbers are not, and ten shapes teach little.
    assert errors[str(models[1])]["test"]["percent"] < 2


@pytest.mark.usefixtures("small_pictures")
def test_random_faces_and_those_between_at_any_resolution(run, trained, eggs, tmp_path):
    first = read_obj(eggs / "egg_00.obj")
    for kind in ("pca", "intrinsic"):
        out, options = tmp_path / kind, ("--model", trained / f"{kind}.safetensors", "--subdivide", 2)
        result = run("sample", "--out-dir", out, "--count", 1, *options)
        assert result.exit_code == 0, result.output
        mesh, face = read_obj(out / "face-000.obj"), read_face(out / "face-000.npz")
        assert len(mesh.polygons) == 4 * (first.polygons >= 0).sum() and len(mesh.uvs) > len(mesh.vertices)
        np.testing.assert_array_equal(face.mesh.polygons, first.polygons)
        assert np.abs(mesh.vertices[:470] - face.vertices).max() < 1e-6
        result = run("interpolate", out / "face-000.npz", eggs / "egg_00.obj", "--out-dir", out, "--steps", 3, *options)
        assert result.exit_code == 0 and "egg_00.obj: had no latent" in result.stderr
        assert np.abs(read_obj(out / "step-002.obj").vertices[:470] - first.vertices).max() < 1e-6


def test_faces_with_other_landmarks_or_of_another_mesh_are_refused(refused, trained, models, dataset, points, tmp_path):
    write_landmarks(tmp_path / "many.npy", Landmarks(points))
    model = trained / "intrinsic.safetensors"
    said = refused("reconstruct-from-landmarks", tmp_path / "many.npy", "--out", tmp_path / "x.obj", "--model", model)
    assert "found 81" in said
    said = refused("evaluate", "shape", model, "--data", dataset)
    assert "intrinsic.safetensors" in said and "470" in said and "4200" in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["many.npy"]
