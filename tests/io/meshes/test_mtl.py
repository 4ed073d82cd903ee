import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.meshes.mtl import material_pictures
from caricli.io.meshes.obj import write_obj
from caricli.structures import Mesh


@pytest.fixture
def written(tmp_path):
    """Write an OBJ and its material from lines; returns the path of the OBJ."""

    def write(obj, mtl=None):
        (tmp_path / "face.obj").write_bytes(obj)
        if mtl is not None:
            (tmp_path / "face.mtl").write_bytes(mtl)
        return tmp_path / "face.obj"

    return write


def test_what_we_write_is_found(tmp_path):
    corners = np.array([[0, 1, 2]])
    mesh = Mesh(np.eye(3), corners, np.eye(3)[:, :2], corners)
    write_obj(tmp_path / "face.obj", mesh, texture="skin.png", others={"eyes": "iris.png"})
    expected = {"face": tmp_path / "skin.png", "eyes": tmp_path / "iris.png"}
    assert material_pictures(tmp_path / "face.obj") == expected


def test_the_first_library_and_all_its_pictures_count(written, tmp_path):
    obj = b"# mtllib not.mtl\r\nmtllib  face.mtl \r\nmtllib other.mtl\nv 0 0 0\n"
    mtl = b"newmtl a\nmap_Ka ambient.png\nmap_Kd my skin \xc3\xa4.png\nnewmtl b\nmap_Kd other.png\n"
    assert material_pictures(written(obj, mtl)) == {"a": tmp_path / "my skin ä.png", "b": tmp_path / "other.png"}


def test_names_that_lead_to_their_own_folder_are_those_of_files_in_it(written, tmp_path):
    assert material_pictures(written(b"mtllib ./face.mtl\n", b"map_Kd ./a.png\n")) == {"": tmp_path / "a.png"}


@pytest.mark.parametrize(
    ("obj", "mtl"),
    [(b"v 0 0 0\n", None), (b"mtllib\n", None), (b"mtllib face.mtl\n", b"newmtl a\nKd 1 1 1\n"),
     (b"mtllib face.mtl\n", b"map_Kd\n")],
)  # fmt: skip
def test_nothing_named_is_no_picture(written, obj, mtl):
    assert material_pictures(written(obj, mtl)) == {}


@pytest.mark.parametrize(
    "name", [b"../x", b"/etc/x", b"a/../../x", b"a/..", b"a//b", b"./", b"..\\x", b"C:x", b"..", b"a\0b"]
)
def test_a_name_that_leads_out_of_the_folder_is_refused(written, name):
    with pytest.raises(
        InputError, match=r"face\.obj: expected the name of a file beside it or below its folder, found"
    ):
        material_pictures(written(b"mtllib " + name + b"\n"))
    with pytest.raises(
        InputError, match=r"face\.mtl: expected the name of a file beside it or below its folder, found"
    ):
        material_pictures(written(b"mtllib face.mtl\n", b"map_Kd " + name + b"\n"))


def test_pictures_in_folders_below_are_those_of_the_material(written, tmp_path):
    mtl = b"newmtl a\nmap_Kd ./textures/skin.png\nnewmtl b\nmap_Kd a/b/my eyes.png\n"
    pictures = material_pictures(written(b"mtllib face.mtl\n", mtl))
    assert pictures == {"a": tmp_path / "textures" / "skin.png", "b": tmp_path / "a" / "b" / "my eyes.png"}


def test_a_folder_below_that_leads_elsewhere_is_refused(written, tmp_path, tmp_path_factory):
    (tmp_path / "textures").symlink_to(tmp_path_factory.mktemp("elsewhere"))
    with pytest.raises(
        InputError, match=r"face\.mtl: expected the name of a file beside it or below its folder, found"
    ):
        material_pictures(written(b"mtllib face.mtl\n", b"map_Kd textures/skin.png\n"))


def test_files_that_cannot_be_read_are_named(written, tmp_path):
    with pytest.raises(InputError, match=r"none\.obj"):
        material_pictures(tmp_path / "none.obj")
    (tmp_path / "face.mtl").mkdir()
    with pytest.raises(InputError, match=r"face\.mtl"):
        material_pictures(written(b"mtllib face.mtl\n"))


def test_a_mesh_that_was_copied_alone_has_no_pictures(written):
    assert material_pictures(written(b"mtllib face.mtl\n")) == {}


def test_names_too_long_for_any_file_are_of_none(written):
    assert material_pictures(written(b"mtllib " + 300 * b"a" + b".mtl\n")) == {}


def test_names_as_windows_writes_them_are_those_of_files_below(written, tmp_path):
    pictures = material_pictures(written(b"mtllib .\\face.mtl\n", b"map_Kd tex\\skin.png\n"))
    assert pictures == {"": tmp_path / "tex" / "skin.png"}
