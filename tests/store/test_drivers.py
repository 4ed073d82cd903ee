from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.mesh import MESH_SUFFIXES, write_mesh
from caricli.io.rig import write_rig
from caricli.methods.expressions.retarget_rig import DrivingLandmarks, DrivingMesh
from caricli.store.drivers import is_driving_mesh, load_driven_rig, load_drivers
from caricli.store.face_pictures import FaceReader
from caricli.store.models import load_morphable
from caricli.structures import Landmarks, Mesh, Rig


@pytest.fixture(scope="module")
def model():
    return load_morphable()


@pytest.fixture
def files(head_template, ball, tmp_path):
    """A mesh, landmarks, and a mesh of another topology."""
    write_mesh(tmp_path / "head.obj", head_template)
    write_mesh(tmp_path / "ball.obj", Mesh(*ball))
    marks = head_template.annotation.landmarks[:68]
    points = 1400 * head_template.vertices[marks, :2] * [1, -1] + [200, 320]
    write_landmarks(tmp_path / "marks.pts", Landmarks(points))
    return tmp_path / "head.obj", tmp_path / "marks.pts", tmp_path / "ball.obj"


def test_meshes_and_landmarks_drive(files, model):
    mesh, marks, other = files
    assert is_driving_mesh(mesh) and not is_driving_mesh(marks)
    done = []
    drivers = load_drivers(files, model, progress=lambda k, total: done.append((k, total)))
    assert done == [(1, 3), (2, 3), (3, 3)] and list(drivers.faces) == [mesh, marks]
    assert isinstance(drivers.faces[mesh], DrivingMesh) and isinstance(drivers.faces[marks], DrivingLandmarks)
    assert drivers.row(marks) == 1 and load_drivers([mesh, marks, mesh], model).rows == [mesh, marks, mesh]
    with pytest.raises(InputError, match="ball.obj: expected the topology"):
        drivers.row(other)
    with pytest.raises(InputError, match="ball.obj: expected the topology"):
        load_drivers(files, model, whole=True)


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_meshes_of_every_format_drive(head_template, model, suffix, tmp_path):
    path = tmp_path / f"head{suffix}"
    write_mesh(path, head_template)
    assert is_driving_mesh(path)
    if suffix == ".stl":  # which numbers vertices anew
        with pytest.raises(InputError, match="head.stl: expected the topology"):
            load_drivers([path], model, whole=True)
    else:
        assert isinstance(load_drivers([path], model).faces[path], DrivingMesh)


def test_other_files_do_not_drive_as_meshes():
    assert is_driving_mesh(Path("face.npz"))
    assert not any(is_driving_mesh(Path(f"marks{suffix}")) for suffix in (".json", ".pts", ".txt", ".npy"))


def test_the_first_pixel_of_pts_files_is_1_or_0(files, model):
    _, marks, _ = files
    readers = (FaceReader(pts_origin=origin) for origin in (1, 0))
    from_one, from_zero = (load_drivers([marks], model, reader).faces[marks].points for reader in readers)
    np.testing.assert_allclose(from_zero, from_one + 1)


def test_rigs_that_cannot_be_driven_are_refused(ball, model, tmp_path):
    vertices, faces = ball
    deltas = np.zeros((1, 300, 3), np.float32)
    normal = np.ones((1, len(model.mean), 3), np.float32)
    rig = Rig(("jawOpen",), Mesh(vertices.astype(np.float32), faces), deltas, normal_deltas=normal)
    cases = {"good": normal, "plain": None, "still": 0 * normal, "other": normal[:, :9]}
    for name, values in cases.items():
        write_rig(tmp_path / f"{name}.npz", replace(rig, normal_deltas=values))
    assert load_driven_rig(tmp_path / "good.npz", model).names == ("jawOpen",)
    for name, words in (("plain", "caricli blendshapes"), ("still", "move a normal face"), ("other", "found 9")):
        with pytest.raises(InputError, match=f"{name}.npz: .*{words}"):
            load_driven_rig(tmp_path / f"{name}.npz", model)
