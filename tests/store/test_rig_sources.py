import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.image import write_png
from caricli.io.meshes.obj import write_obj
from caricli.store.any_file import files_beside
from caricli.store.rig_sources import PictureSources, load_shown_face, picture_sources
from caricli.structures import Mesh


def test_a_file_is_named_once_where_its_material_leads_away(tmp_path):
    faces = np.array([[0, 1, 2]], np.int32)
    write_obj(tmp_path / "face.obj", Mesh(np.eye(3), faces, np.eye(3)[:, :2], faces))
    (tmp_path / "face.obj").write_text("mtllib ../a.mtl\n" + (tmp_path / "face.obj").read_text())
    with pytest.raises(InputError) as refused:
        load_shown_face(tmp_path / "face.obj")
    words = "expected the name of a file beside it or below its folder, found '../a.mtl'"
    assert str(refused.value) == f"{tmp_path / 'face.obj'}: {words}"


def test_a_mesh_wears_a_picture_in_a_folder_below_its_own(tmp_path):
    faces = np.array([[0, 1, 2]], np.int32)
    write_obj(tmp_path / "scan.obj", Mesh(np.eye(3), faces, np.eye(3)[:, :2], faces), "skin.png")
    mtl = tmp_path / "scan.mtl"
    mtl.write_text(mtl.read_text().replace("map_Kd skin.png", "map_Kd textures/skin.png"))
    (tmp_path / "textures").mkdir()
    write_png(tmp_path / "textures" / "skin.png", np.full((4, 4, 3), 9, np.uint8))
    assert (load_shown_face(tmp_path / "scan.obj").pictures.skin == 9).all()
    assert files_beside(tmp_path / "scan.obj") == ["scan.mtl", "textures/skin.png"]


def test_eyes_and_bust_lie_beside_the_picture_of_the_skin(tmp_path):
    faces = np.array([[0, 1, 2]], np.int32)
    mesh = Mesh(np.eye(3), faces, np.eye(3)[:, :2], faces)
    write_obj(tmp_path / "face.obj", mesh, "skin.png")
    write_png(tmp_path / "skin.png", np.zeros((4, 4, 3), np.uint8))
    skin = tmp_path / "skin.png"
    for name, sources in (
        ("bust.png", PictureSources(skin, bust=tmp_path / "bust.png")),
        ("eyes.png", PictureSources(skin, tmp_path / "eyes.png", bust=tmp_path / "bust.png")),
    ):
        write_png(tmp_path / name, np.zeros((4, 4, 3), np.uint8))
        assert picture_sources(tmp_path / "face.obj") == picture_sources(tmp_path / "face.npz") == sources
    assert picture_sources(tmp_path / "face.obj", skin) == sources
