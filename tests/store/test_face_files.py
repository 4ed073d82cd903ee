from dataclasses import replace

import numpy as np
import pytest

from caricli.io.face import read_face
from caricli.io.meshes.mesh import read_mesh
from caricli.io.strict_json import read_json
from caricli.methods.faces.draw_face import FaceDrawing
from caricli.methods.faces.encode_face import encode_face
from caricli.store.drawings import load_drawing
from caricli.store.face_files import FaceSeries, write_face_files, write_face_result
from caricli.structures import Camera, Face, Pictures


@pytest.fixture(scope="module")
def drawing():
    return load_drawing(None, 1, 32)


@pytest.fixture(scope="module")
def face(drawing):
    model = drawing.model
    latent = model.prior.sample(np.random.default_rng(0), 1)[0]
    camera = Camera(900.0, np.diag([1.0, -1, -1]), np.ones(2))
    mesh = model.template.with_vertices(model.decode(latent))
    return encode_face(Face(mesh, camera, np.zeros((68, 2)), latent, model_id=model.model_id), model)


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".glb"])
def test_the_fine_mesh_in_any_format_and_the_models_own_for_the_next_command(drawing, face, tmp_path, suffix):
    mesh_file, npz_file = tmp_path / f"a{suffix}", tmp_path / "a.npz"
    finer = drawing.finer(face)
    write_face_files(mesh_file, npz_file, face, drawing.mesh_face(face))
    mesh, stored = read_mesh(mesh_file), read_face(npz_file)
    np.testing.assert_allclose(mesh.vertices, finer.mesh.vertices, atol=1e-7)
    np.testing.assert_allclose(stored.vertices, face.vertices, atol=1e-7)
    assert stored.camera.scale == 900 and stored.landmarks.shape == (68, 2) and stored.model_id == face.model_id
    # The face is one of the model's own: what it leaves over is rounding.
    assert np.abs(face.residual).max() < 1e-6 and stored.residual is None


def test_a_residual_that_says_something_is_kept(drawing, face, tmp_path):
    other = encode_face(Face(face.mesh.with_vertices(1.1 * face.vertices)), drawing.model)
    write_face_files(tmp_path / "a.obj", tmp_path / "a.npz", other, drawing.mesh_face(other))
    np.testing.assert_array_equal(read_face(tmp_path / "a.npz").residual, other.residual.astype(np.float32))


def test_all_four_files(drawing, face, tmp_path):
    files = [tmp_path / f"a{suffix}" for suffix in (".obj", ".npz", ".json", ".png")]
    write_face_result(files, face, drawing, {"share": 1.0}, lambda: np.zeros((4, 4, 3), np.uint8))
    assert all(path.is_file() for path in files) and read_json(files[2]) == {"share": 1.0}


def test_faces_of_a_series_that_wear_the_same_share_its_file(drawing, face, tmp_path):
    skins = [np.full((4, 4, 3), shade, np.uint8) for shade in (9, 9, 200)]
    faces = ((replace(face, pictures=Pictures(skin)), {}) for skin in skins)
    series = FaceSeries(tmp_path, "face", 3, "sheet")
    series.write(series.files, faces, drawing, (), lambda *_: None)
    assert sorted(path.name for path in tmp_path.glob("*.png")) == ["face-000-skin.png", "face-002-skin.png"]
    for stem, skin in zip(series.stems, skins, strict=True):
        np.testing.assert_array_equal(read_face(tmp_path / f"{stem}.npz").pictures.skin, skin)


def test_a_series_is_written_as_it_comes(drawing, face, tmp_path):
    series = FaceSeries(tmp_path, "face", 3, "sheet")
    assert [path.name for path in series.files[:3]] == ["face-000.obj", "face-000.npz", "face-001.obj"]
    assert [path.name for path in series.files[-2:]] == ["sheet.png", "sheet.json"]
    done = []
    faces = ((face, {"number": number}) for number in range(3))
    coarse = FaceDrawing(drawing.model, load_drawing(None, 0, 32).fine, 32)
    rows, views = series.write(series.files, faces, coarse, {0, 2}, lambda *progress: done.append(progress))
    assert rows == [{"face": f"face-00{number}", "number": number} for number in range(3)]
    assert len(views) == 2 and views[0][0].shape == (32, 32, 4) and done == [(1, 3), (2, 3), (3, 3)]
    assert all(path.is_file() for path in series.files[:-2])
