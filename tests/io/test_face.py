import dataclasses
import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from caricli.errors import InputError, OutputError
from caricli.io.face import read_face, read_picture_names, write_face
from caricli.io.meshes.obj import write_obj
from caricli.io.npz import read_npz, write_npz
from caricli.io.worn import PictureNames
from caricli.structures import Camera, Face, Material, Mesh, Pictures
from caricli.structures.checks import are_apart
from caricli.structures.mesh import topology_id

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.1]])
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def quad(vertices=VERTICES):
    uvs = np.array([[0, 0], [1, 0], [1, 0.1]])
    return Mesh(vertices, np.array([[0, 1, 2, 3]], np.int32), uvs, np.array([[0, 1, 2, 1]], np.int32))


def full():
    return Face(
        quad(),
        Camera(2.5, np.diag([1.0, -1.0, -1.0]), np.array([3.0, 4.0])),
        latent=np.arange(5.0),
        residual=np.arange(36.0).reshape(4, 9),
        landmarks=np.arange(136.0).reshape(68, 2),
        model_id="intrinsic",
        pictures=Pictures(np.full((4, 6, 3), 90, np.uint8), np.arange(48, dtype=np.uint8).reshape(4, 4, 3)),
        materials=np.array([Material.EYE], np.int32),
    )


def assert_equal(face, other):
    assert (face.camera is None) == (other.camera is None)
    pairs = [(face, other), (face.mesh, other.mesh), (face.pictures, other.pictures)] + (
        [(face.camera, other.camera)] if face.camera else []
    )
    for left, right in pairs:
        for name in [
            field.name for field in dataclasses.fields(left) if field.name not in ("mesh", "camera", "pictures")
        ]:
            value, expected = getattr(left, name), getattr(right, name)
            assert (value is None) == (expected is None), name
            if expected is not None:
                np.testing.assert_array_equal(value, expected, name)


def test_all_fields_come_back(tmp_path):
    write_face(tmp_path / "a.npz", full())
    back = read_face(tmp_path / "a.npz")
    expected = dataclasses.replace(full(), mesh=quad(VERTICES.astype(np.float32)))
    assert_equal(back, expected)
    assert back.vertices.dtype == np.float64 and back.faces.dtype == np.int32
    assert type(back.camera.scale) is float and type(back.model_id) is str
    stored = read_npz(tmp_path / "a.npz")
    assert stored["schema"] == "caricli.face/1" and stored["units"] == "m" and stored["axes"] == "+y up, +z front"
    assert stored["topology_id"] == hashlib.sha256(FACES.tobytes()).hexdigest()
    assert stored["vertices"].dtype == np.float32 and stored["faces"].dtype == np.int32


def test_pictures_lie_beside_the_face(tmp_path):
    write_face(tmp_path / "a.npz", full())
    assert {path.name for path in tmp_path.iterdir()} == {"a.npz", "a-skin.png", "a-eyes.png"}
    assert read_picture_names(tmp_path / "a.npz") == PictureNames("a-skin.png", "a-eyes.png")
    write_face(tmp_path / "b.npz", full(), PictureNames("a-skin.png"))
    assert read_face(tmp_path / "b.npz").pictures.eyes is None and not (tmp_path / "b-skin.png").exists()
    (tmp_path / "a-eyes.png").unlink()
    with pytest.raises(InputError, match=r"a\.npz: expected its picture a-eyes\.png beside it, found none"):
        read_face(tmp_path / "a.npz")


@pytest.mark.parametrize("name", ["e\udcff", "12:30", "a\\b"])
def test_a_name_that_no_file_can_hold_is_for_faces_without_pictures(tmp_path, name):
    path = tmp_path / f"{name}.npz"
    with pytest.raises(OutputError, match=r"npz: expected a name in UTF-8 without colons and backslashes"):
        write_face(path, full())
    assert not [*tmp_path.iterdir()]
    write_face(path, dataclasses.replace(full(), pictures=Pictures()))
    read_face(path)


def test_dots_in_a_name_lead_nowhere(tmp_path):
    write_face(tmp_path / "v1..2.npz", full())
    assert read_face(tmp_path / "v1..2.npz").pictures.same(full().pictures)


@pytest.mark.parametrize("name", ["../x.png", "/etc/x.png", "a/b.png", "a\\b.png", "C:x.png"])
def test_pictures_elsewhere_are_refused(tmp_path, name):
    write_face(tmp_path / "a.npz", full())
    write_npz(tmp_path / "a.npz", read_npz(tmp_path / "a.npz") | {"skin_picture": np.array(name)})
    for read in (read_face, read_picture_names):
        with pytest.raises(InputError, match="expected the name of a file beside it"):
            read(tmp_path / "a.npz")


def test_pictures_need_uvs_and_materials_polygons():
    with pytest.raises(InputError, match="uvs: expected them on a face with pictures"):
        Face(Mesh(VERTICES, FACES), pictures=full().pictures)
    for materials in (np.zeros(2, np.int32), np.array([99], np.int32)):
        with pytest.raises(InputError, match="materials: expected"):
            Face(quad(), materials=materials)


def test_absent_fields_stay_absent(tmp_path):
    write_face(tmp_path / "a.npz", Face(Mesh(VERTICES, FACES)))
    assert set(read_npz(tmp_path / "a.npz")) == {"schema", "units", "axes", "topology_id", "vertices", "faces"}
    assert read_face(tmp_path / "a.npz").latent is None


@settings(max_examples=50, deadline=None, derandomize=True)
@given(data=st.data())
def test_round_trip(tmp_path_factory, data):
    number = st.floats(-1e6, 1e6, width=32)
    optional = {
        "latent": arrays(np.float32, 7, elements=number),
        "residual": arrays(np.float32, (4, 9), elements=number),
        "camera": st.builds(
            Camera,
            st.floats(1e-6, 1e6),
            st.just(np.diag([-1.0, 1, -1])),
            arrays(np.float64, 2, elements=st.floats(-1e6, 1e6)),
        ),
        "landmarks": arrays(np.float64, (81, 2), elements=st.floats(-1e6, 1e6)),
        "teeth": arrays(np.float32, 2, elements=st.floats(0, 1, width=32)),
        "model_id": st.text(st.characters(exclude_categories=["Cs", "Cc"]), min_size=1, max_size=9),
    }
    chosen = data.draw(st.fixed_dictionaries({}, optional=optional))
    face = Face(Mesh(data.draw(arrays(np.float32, (4, 3), elements=number).filter(are_apart)), FACES), **chosen)
    path = tmp_path_factory.mktemp("face") / "a.npz"
    write_face(path, face)
    assert_equal(read_face(path), face)


def test_obj_gives_the_geometry(tmp_path):
    write_obj(tmp_path / "a.obj", quad())
    back = read_face(tmp_path / "a.obj")
    assert_equal(back, Face(quad()))
    write_face(tmp_path / "a.npz", back)
    through = read_face(tmp_path / "a.npz").mesh
    write_obj(tmp_path / "b.obj", through.with_vertices(VERTICES))
    assert (tmp_path / "b.obj").read_bytes() == (tmp_path / "a.obj").read_bytes()


@pytest.mark.parametrize(
    ("name", "content", "kind"), [("a.txt", b"hello", "another kind of file"), ("a.png", b"\x89PNG\r\n", "a PNG image")]
)
def test_what_no_face_can_be_is_told_what_can(name, content, kind, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=rf"{name}: expected a face .NPZ. or a mesh .OBJ, .*, found {kind}"):
        read_face(tmp_path / name)


def test_a_face_of_another_name_is_read(tmp_path):
    write_face(tmp_path / "a.npz", Face(quad()))
    (tmp_path / "a.npz").rename(tmp_path / "face")
    assert len(read_face(tmp_path / "face").vertices) == len(VERTICES)


def test_polygons_become_fans(tmp_path):
    text = "".join(f"v {k} {k * k} 0\n" for k in range(5)) + "f 1 2 3\nf 5 4 3 2 1\nf 1 3 5 4\n"
    (tmp_path / "a.obj").write_text(text)
    expected = [[0, 1, 2], [4, 3, 2], [4, 2, 1], [4, 1, 0], [0, 2, 4], [0, 4, 3]]
    assert read_face(tmp_path / "a.obj").faces.tolist() == expected


def test_topology_id_is_of_the_indices_alone():
    assert topology_id(FACES) == topology_id(np.asfortranarray(FACES.astype(np.int64)))
    assert topology_id(FACES) != topology_id(FACES[::-1])


CHANGES = [
    ({"schema": np.array("caricli.face/2")}, "expected a face with schema 'caricli.face/1'"),
    ({"schema": None}, "expected a face with schema"),
    ({"schema": np.array([1.0])}, "expected a face with schema"),
    ({"units": np.array("mm")}, "expected a face with units 'm'"),
    ({"axes": np.array("+z up")}, "expected a face with axes"),
    ({"topology_id": np.array("0" * 64)}, "topology_id that matches the faces"),
    ({"topology_id": None}, "topology_id"),
    ({"vertices": None}, "expected a face with vertices, found none"),
    ({"faces": None}, "expected a face with faces, found none"),
    ({"extra": np.zeros(1)}, "found 'extra'"),
    ({"vertices": VERTICES[:, :2]}, r"vertices: expected \(V,3\)"),
    ({"vertices": VERTICES * np.nan}, "vertices: expected finite coordinates"),
    ({"vertices": VERTICES + np.inf}, "vertices: expected finite coordinates"),
    ({"vertices": VERTICES * 1e308}, "vertices: expected finite coordinates"),
    ({"vertices": np.full((4, 3), "a")}, "vertices: expected float32, found <U1"),
    ({"faces": FACES.astype(float)}, "faces: expected int32, found float64"),
    ({"faces": FACES.astype(np.int64) + 2**32}, "faces: expected indices from 0"),
    ({"faces": FACES + 1}, "faces: expected indices below 4, found 4"),
    ({"faces": FACES - 1}, "faces: expected rows of at least 3 indices"),
    ({"faces": FACES * 0}, "faces: expected distinct corners, found one twice in row 0"),
    ({"faces": FACES[:0]}, "faces: expected"),
    ({"polygons": np.array([[0, 1, -1, 2]])}, "polygons: expected rows"),
    ({"polygons": np.array([[0, 1, 2, 4]])}, "polygons: expected indices below 4"),
    ({"polygons": np.zeros((1, 65), int)}, "polygons: expected"),
    ({"polygons": None}, "polygons: expected them beside the UVs"),
    ({"uvs": None}, "uvs: expected them together with uv_polygons"),
    ({"uvs": np.zeros((3, 3))}, r"uvs: expected \(T,2\)"),
    ({"uvs": np.full((3, 2), np.nan)}, "uvs: expected finite"),
    ({"uv_polygons": np.array([[0, 1, 2, -1]])}, "uv_polygons: expected an index for every corner"),
    ({"uv_polygons": np.array([[0, 1, 2, 3]])}, "uv_polygons: expected indices below 3"),
    ({"latent": np.zeros((2, 2))}, r"latent: expected the shape \(\*\)"),
    ({"latent": np.zeros(0)}, "latent: expected the shape"),
    ({"latent": np.full(3, np.nan)}, "latent: expected finite numbers"),
    ({"residual": np.zeros((3, 9))}, r"residual: expected the shape \(4,9\), found \(3, 9\)"),
    ({"camera_scale": np.zeros(1)}, "camera_scale: expected the shape"),
    ({"camera_scale": np.array(0.0)}, "camera_scale: expected from 1e-06"),
    ({"camera_rotation": np.diag([1.0, 1.0, -1.0])}, "camera_rotation: expected a proper rotation"),
    ({"camera_rotation": 2 * np.eye(3)}, "camera_rotation: expected a proper rotation"),
    ({"camera_rotation": np.eye(3) * 1e200}, "camera_rotation: expected"),
    ({"camera_translation": np.zeros(3)}, "camera_translation: expected the shape"),
    ({"landmarks": np.full((68, 2), np.nan)}, "landmarks: expected finite coordinates"),
    ({"landmarks": np.zeros((68, 3))}, "landmarks: expected the shape"),
    ({"model_id": np.array(3)}, "model_id: expected text"),
]


@pytest.mark.parametrize(("changes", "message"), CHANGES)
def test_malformed(tmp_path, changes, message):
    write_face(tmp_path / "good.npz", full())
    arrays_of = {**read_npz(tmp_path / "good.npz"), **changes}
    write_npz(tmp_path / "a.npz", {key: value for key, value in arrays_of.items() if value is not None})
    with pytest.raises(InputError, match=message) as caught:
        read_face(tmp_path / "a.npz")
    assert "a.npz" in str(caught.value) and "\n" not in str(caught.value)
