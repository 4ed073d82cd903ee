import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.face import write_face
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import write_png
from caricli.io.meshes.obj import write_obj
from caricli.store.any_file import files_beside
from caricli.store.rig_sources import PictureSources, load_pictures, load_shown_face, picture_sources
from caricli.structures import Face, Material, Mesh, Pictures, Rig


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


def test_every_polygon_of_an_obj_wears_what_its_material_names(tmp_path):
    faces = np.tile([[0, 1, 2]], (4, 1))
    mesh = Mesh(np.eye(3), faces, np.eye(3)[:, :2], faces)
    materials = np.array([Material.SKIN, Material.EYE, Material.TEETH, Material.HAIR], np.int32)
    names = {"skin": "s.png", "eyes": "e.png", "hair": "h.png", "bust": "b.png"}
    for k, name in enumerate(names.values()):
        write_png(tmp_path / name, np.full((4, 4, 3), k, np.uint8))
    write_obj(tmp_path / "a.obj", mesh, "s.png", others=names, materials=materials)
    text = (tmp_path / "a.obj").read_text()
    (tmp_path / "a.obj").write_text(text.replace("usemtl hair", "usemtl hair.001"))
    mtl = tmp_path / "a.mtl"
    mtl.write_text(mtl.read_text().replace("newmtl hair", "newmtl hair.001"))
    face = load_shown_face(tmp_path / "a.obj")
    np.testing.assert_array_equal(face.materials, materials)
    assert [picture.max() for picture in face.pictures] == [0, 1, 2, 3]


def test_the_skin_of_an_obj_is_the_picture_of_most_polygons(tmp_path):
    """In whatever order the materials stand, and of whatever names; those all of skin say nothing of it."""
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
    face = "f 1/1 2/2 3/3\n"
    mtl = [f"newmtl {name}\nmap_Kd {name}.png\n" for name in ("hair", "shirt", "head")]
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{points}usemtl shirt\n{face}usemtl head\n{2 * face}")
    for order in (mtl, mtl[::-1]):
        (tmp_path / "a.mtl").write_text("".join(order))
        assert picture_sources(tmp_path / "a.obj").skin == tmp_path / "head.png"
    for name in ("hair", "head"):
        write_png(tmp_path / f"{name}.png", np.zeros((4, 4, 3), np.uint8))
    assert load_shown_face(tmp_path / "a.obj").materials is None


def test_another_skin_leaves_eyes_and_hair_as_they_are(tmp_path):
    """And brings the eyes that lie beside it; a bust has the colours of its own skin."""
    faces = np.array([[0, 1, 2]], np.int32)
    mesh = Mesh(np.eye(3), faces, np.eye(3)[:, :2], faces)
    shades = {name: np.full((4, 4, 3), k, np.uint8) for k, name in enumerate(("skin", "eyes", "hair", "bust"))}
    (tmp_path / "own").mkdir()
    own = tmp_path / "own" / "face.npz"
    write_face(own, Face(mesh, pictures=Pictures(**shades)))
    other = tmp_path / "other.png"
    write_png(other, np.full((4, 4, 3), 99, np.uint8))
    pictures = load_pictures(own, other)
    assert [None if each is None else each.max() for each in pictures] == [99, 1, 2, None]
    write_png(tmp_path / "eyes.png", np.full((4, 4, 3), 88, np.uint8))
    assert load_pictures(own, other).eyes.max() == 88
    assert [each.max() for each in load_pictures(own)] == [0, 1, 2, 3]


@pytest.mark.parametrize("other", [False, True])
def test_a_painted_glb_keeps_its_picture(tmp_path, other):
    faces = np.array([[0, 1, 2]], np.int32)
    mesh = Mesh(np.eye(3, dtype=np.float32), faces, np.eye(3)[:, :2], faces)
    painted = Rig((), mesh, np.zeros((0, 3, 3), np.float32), pictures=Pictures(np.full((4, 4, 3), 7, np.uint8)))
    write_gltf(tmp_path / "face.glb", painted)
    write_png(tmp_path / "other.png", np.full((4, 4, 3), 99, np.uint8))
    skin = load_pictures(tmp_path / "face.glb", tmp_path / "other.png" if other else None).skin
    assert skin.max() == (99 if other else 7)


@pytest.mark.parametrize("suffix", [".glb", ".ply", ".stl"])
def test_what_lies_beside_another_kind_of_file_is_not_its_own(tmp_path, suffix):
    (tmp_path / "face.obj").write_text("mtllib face.mtl\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "face.mtl").write_text("newmtl skin\nmap_Kd texture.png\n")
    write_png(tmp_path / "texture.png", np.zeros((4, 4, 3), np.uint8))
    assert picture_sources(tmp_path / "face.obj").skin == tmp_path / "texture.png"
    assert picture_sources(tmp_path / f"face{suffix}") == PictureSources()
