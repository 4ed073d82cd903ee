import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from caricli.errors import InputError, OutputError
from caricli.io.meshes import obj
from caricli.io.meshes.obj import read_obj, read_painted_obj, write_obj
from caricli.structures import Material, Mesh
from caricli.structures.checks import are_apart
from caricli.structures.materials import FINISHES

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def read(folder, text):
    path = folder / "a.obj"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_obj(path)


def test_polygons_order_and_uv_seams_are_kept(tmp_path):
    mesh = read(
        tmp_path,
        "mtllib x.mtl\no head\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1 0\nvt .5 .5\nvn 0 0 1\ng a\nusemtl m\ns off\n"
        "f 2/2/1 3/3/1 4/4/1 1/1/1\nf 1/5/1 2/2/1 3/3/1\n",
    )
    assert mesh.vertices.dtype == np.float64 and mesh.polygons.dtype == np.int32
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9]]
    assert mesh.polygons.tolist() == [[1, 2, 3, 0], [0, 1, 2, -1]]
    assert mesh.uvs.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]
    assert mesh.uv_polygons.tolist() == [[1, 2, 3, 0], [4, 1, 2, -1]]


@pytest.mark.parametrize(
    "text",
    [
        TRIANGLE + "f 1 2 3\n",
        TRIANGLE + "f 1 2 3",
        TRIANGLE.replace("\n", "\r\n") + "f 1 2 3\r\n",
        TRIANGLE.replace("\n", "\r") + "f 1 2 3\r",
        TRIANGLE + "f -3 -2 -1\n",
        TRIANGLE + "f -3 -2 -1\nv 5 5 5\n".replace("v 5 5 5\n", ""),
        TRIANGLE + "f 1//1 2//1 3//7\n",
        TRIANGLE + "f \\\n 1 2 \\\n 3\n",
        TRIANGLE + "f 1 2 3 \\",
        "# a comment\n\n" + TRIANGLE + "  f\t1  2 3 # the only one\n",
        "v 0 0 0 .1 .2 .3\nv 1 0 0 1\nv 0 1 0 1 .1 .2 .3\nf 1 2 3\n",
        "v 0 0 0\nv +1e0 -0 0.\nf 1 2 3\nv 0 1 0\n",
        "g caf\u00e9\n" + TRIANGLE + "l 1 2\np 1\nf 1 2 3\n",
        b"g caf\xe9\n" + TRIANGLE.encode() + b"f 1 2 3\n",
        TRIANGLE + "vt 0 0\nf 1 2 3\n",
    ],
)
def test_the_same_triangle_in_many_spellings(tmp_path, text):
    mesh = read(tmp_path, text)
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.polygons.tolist() == [[0, 1, 2]]
    assert mesh.uvs is None and mesh.uv_polygons is None


def test_negative_indices_count_from_their_line(tmp_path):
    mesh = read(tmp_path, TRIANGLE + "vt 0 0\nvt 1 0\nvt 0 1\nf -3/-3 -2/-2 -1/-1\nv 2 2 2\nvt 1 1\nf -1/-1 1/1 2/2\n")
    assert mesh.polygons.tolist() == [[0, 1, 2], [3, 0, 1]]
    assert mesh.uv_polygons.tolist() == [[0, 1, 2], [3, 0, 1]]


def test_mixed_normals_and_sizes(tmp_path):
    corners = "".join(f"v {k} {k * k} 0\n" for k in range(64))
    polygon = "f " + " ".join(str(k + 1) for k in range(64)) + "\n"
    mesh = read(tmp_path, corners + "f 1 2 3\n" + polygon + "f 1//1 3//1 2//1\n")
    assert mesh.polygons.shape == (3, 64)
    assert mesh.polygons[1].tolist() == list(range(64))
    assert mesh.polygons[2, :4].tolist() == [0, 2, 1, -1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TRIANGLE + "f 0 1 2\n", r"line 4: expected the number of a vertex from 1 to 3, found '0'"),
        (TRIANGLE + "f 1 2 4\n", r"line 4: .* found '4'"),
        (TRIANGLE + "f 1 2 -4\n", r"line 4: .* found '-4'"),
        (TRIANGLE + "f 1 2 3\nf -1 -2 -3\nf 1 2 -9\n", r"line 6: .* found '-9'"),
        (TRIANGLE + "f 1 2 99999999999999999999\n", "line 4: expected corners of the form v"),
        (TRIANGLE + "vt 0 0\nf 1/1 2/1 3/2\n", "line 5: expected the number of a texture coordinate from 1 to 1"),
        (TRIANGLE + "vt 0 0\nf 1/0 2/1 3/1\n", "line 5: expected the number of a texture coordinate"),
        (TRIANGLE + "f 1/1 2/1 3/1\n", "from 1 to 0"),
        (TRIANGLE + "f 1 2\n", "line 4: expected a face with 3 to 64 corners, found 'f 1 2'"),
        (TRIANGLE + "f\n", "line 4: expected a face"),
        (TRIANGLE + "f " + "1 " * 65 + "\n", "line 4: expected a face with 3 to 64 corners"),
        (TRIANGLE + "f 1 2 2\n", "line 4: expected a face with distinct vertices"),
        (TRIANGLE + "f 1 2 3\nf 1 -3 3\n", "line 5: expected a face with distinct vertices"),
        (TRIANGLE + "f 1 2 x\n", "line 4: expected corners of the form v, found 'f 1 2 x'"),
        (TRIANGLE + "f 1 2 3.0\n", "line 4: expected corners"),
        (TRIANGLE + "f 1/1 2 3/1\n", "line 4: expected corners"),
        (TRIANGLE + "f 1/ 2/ 3/\n", "line 4: expected corners"),
        (TRIANGLE + "vt 0 0\nf 1 2 3\nf 1/1 2/1 3/1\n", "line 6: expected a face without texture coordinates"),
        (TRIANGLE + "vt 0 0\nf 1/1 2/1 3/1\nf 1 2 3\n", "line 6: expected a face with texture coordinates"),
        ("v 0 0\n", "line 1: expected v with 3 to 7 numbers, found 'v 0 0'"),
        ("v\n", "line 1: expected v with"),
        ("v 1 2 3 4 5 6 7 8\n", "line 1: expected v with"),
        (TRIANGLE + "vt 0\nf 1/1 2/1 3/1\n", "line 4: expected vt with 2 to 3 numbers"),
        (TRIANGLE.replace("1", "nan") + "f 1 2 3\n", "line 2: expected a finite coordinate .*, found 'nan'"),
        (TRIANGLE.replace("1", "-inf") + "f 1 2 3\n", "line 2: .* found '-inf'"),
        (TRIANGLE.replace("1", "1e308") + "f 1 2 3\n", "line 2: .* found '1e308'"),
        (TRIANGLE.replace("1", "1e999") + "f 1 2 3\n", "line 2: .* found '1e999'"),
        (TRIANGLE.replace("1", "1000001") + "f 1 2 3\n", "at most 1e\\+06, found '1000001'"),
        (TRIANGLE.replace("1", "1_0") + "f 1 2 3\n", "found '1_0'"),
        (TRIANGLE.replace("1", "x") + "f 1 2 3\n", "line 2: .* found 'x'"),
        (TRIANGLE + "vt nan 0\nf 1/1 2/1 3/1\n", "line 4: expected a finite coordinate"),
        (TRIANGLE, "expected a mesh with faces, found none"),
        ("f 1 2 3\n", "found no vertices"),
        ("# nothing\n", "found no vertices"),
        ("hello world\n", "line 1: expected an OBJ keyword, found 'hello'"),
        ("138 198\n", "line 1: expected an OBJ keyword, found '138'"),
        ("v 1 2 " + "3" * 9000, "line 1: expected a line of at most 8192 bytes"),
        ("v \\\n" * 5000, "line 1: expected a line of at most 8192 bytes"),
    ],
)
def test_malformed_files(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, text)
    assert "a.obj" in str(caught.value) and "\n" not in str(caught.value)


def test_counts_are_capped(tmp_path, monkeypatch):
    text = TRIANGLE + "f 1 2 3\nf 1 3 2\n"
    for name, value in {"MAX_VERTICES": 2, "MAX_POLYGONS": 1, "MAX_CORNERS": 5, "MAX_FILE_BYTES": 30}.items():
        with monkeypatch.context() as patch:
            patch.setattr(obj, name, value)
            with pytest.raises(InputError, match=f"at most {value}"):
                read(tmp_path, text)
    assert len(read(tmp_path, text).polygons) == 2


@st.composite
def meshes(draw):
    count = draw(st.integers(3, 9))
    coordinate = st.floats(-1e6, 1e6, width=32)
    vertices = draw(arrays(np.float32, (count, 3), elements=coordinate).filter(are_apart))
    rows = draw(
        st.lists(
            st.permutations(range(count)).flatmap(lambda p: st.integers(3, count).map(lambda n: p[:n])),
            min_size=1,
            max_size=6,
        )
    )
    width = max(map(len, rows))
    polygons = np.array([row + [-1] * (width - len(row)) for row in rows], np.int32)
    if draw(st.booleans()):
        return Mesh(vertices, polygons)
    uvs = draw(arrays(np.float32, (draw(st.integers(1, 9)), 2), elements=coordinate))
    indices = draw(arrays(np.int32, polygons.shape, elements=st.integers(0, len(uvs) - 1)))
    return Mesh(vertices, polygons, uvs, np.where(polygons < 0, -1, indices).astype(np.int32))


@settings(max_examples=100, deadline=None, derandomize=True)
@given(mesh=meshes())
def test_round_trip(tmp_path_factory, mesh):
    path = tmp_path_factory.mktemp("obj") / "a.obj"
    write_obj(path, mesh)
    back = read_obj(path)
    np.testing.assert_array_equal(back.vertices.astype(np.float32), mesh.vertices)
    np.testing.assert_array_equal(back.polygons, mesh.polygons)
    assert (back.uvs is None) == (mesh.uvs is None)
    if mesh.uvs is not None:
        np.testing.assert_array_equal(back.uvs.astype(np.float32), mesh.uvs)
        np.testing.assert_array_equal(back.uv_polygons, mesh.uv_polygons)
    text = path.read_bytes()
    write_obj(path, back)
    assert path.read_bytes() == text


def square():
    polygons = np.array([[0, 1, 2, 3]], np.int32)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    return Mesh(np.c_[corners, np.zeros(4)], polygons, corners, polygons)


def test_what_has_no_picture_has_its_colour(tmp_path):
    mesh = Mesh(square().vertices, np.array([[0, 1, 2], [0, 2, 3]]))
    write_obj(tmp_path / "a.obj", mesh, materials=np.array([Material.SKIN, Material.TONGUE]))
    rows = [line for line in (tmp_path / "a.obj").read_text().splitlines() if line[0] in "uf"]
    assert rows == ["usemtl face", "f 1 2 3", "usemtl tongue", "f 1 3 4"]
    texts = (tmp_path / "a.mtl").read_text().split("newmtl ")[1:]
    assert [text.split()[0] for text in texts] == ["face", "tongue"]
    assert "Kd 0.8078 0.6275 0.5333" in texts[0] and "Kd 0.7765 0.4078 0.4078" in texts[1]


def test_the_surface_is_smooth(tmp_path):
    write_obj(tmp_path / "a.obj", square())
    lines = (tmp_path / "a.obj").read_text().splitlines()
    assert lines.index("s 1") < lines.index("f 1/1 2/2 3/3 4/4")


def test_eyes_are_a_material_of_their_own(tmp_path):
    mesh = Mesh(np.eye(3), np.tile([[0, 1, 2]], (4, 1)), np.eye(3)[:, :2], np.tile([[0, 1, 2]], (4, 1)))
    materials = np.array([Material.SKIN, Material.EYE, Material.EYE, Material.SKIN])
    write_obj(tmp_path / "a.obj", mesh, others={"eyes": "iris.png"}, materials=materials)
    rows = [line for line in (tmp_path / "a.obj").read_text().splitlines() if line.startswith(("usemtl", "f "))]
    face = "f 1/1 2/2 3/3"
    assert rows == ["usemtl face", face, "usemtl eyes", face, face, "usemtl face", face]
    texts = (tmp_path / "a.mtl").read_text().split("newmtl ")[1:]
    assert [text.split()[0] for text in texts] == ["face", "eyes"]
    assert "map_Kd" not in texts[0] and "map_Kd iris.png" in texts[1]
    np.testing.assert_array_equal(read_obj(tmp_path / "a.obj").polygons, mesh.polygons)


def test_polygons_are_of_the_material_that_was_named_last(tmp_path):
    lines = ["f 1 2 3", "usemtl my skin ", "f 1 2 3", "o x", "f 1 2 3", "usemtl eyes", "f 1 2 3", "usemtl", "f 1 2 3"]
    (tmp_path / "a.obj").write_text(TRIANGLE + "\n".join(lines))
    _, names = read_painted_obj(tmp_path / "a.obj")
    assert names == ["", "my skin", "my skin", "eyes", ""]


def test_texture_and_material(tmp_path):
    write_obj(tmp_path / "a.obj", square(), texture="a.png")
    text = (tmp_path / "a.obj").read_text()
    assert "mtllib a.mtl\n" in text and text.index("usemtl face\n") < text.index("f 1/1 2/2 3/3 4/4\n")
    assert "newmtl face\n" in (tmp_path / "a.mtl").read_text()
    assert "map_Kd a.png\n" in (tmp_path / "a.mtl").read_text()
    write_obj(tmp_path / "b.obj", square(), texture="a.png", mtl=tmp_path / "other.mtl")
    assert "mtllib other.mtl\n" in (tmp_path / "b.obj").read_text()
    assert (tmp_path / "other.mtl").exists() and not (tmp_path / "b.mtl").exists()
    np.testing.assert_array_equal(read_obj(tmp_path / "b.obj").uv_polygons, square().uv_polygons)


def test_what_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(OutputError, match="UVs for the texture"):
        write_obj(tmp_path / "a.obj", Mesh(square().vertices, square().polygons), texture="a.png")
    for texture in ("../a.png", "a\nb.png", "12:30.png", ""):
        with pytest.raises(OutputError, match="plain file name"):
            write_obj(tmp_path / "a.obj", square(), texture=texture)
    with pytest.raises(OutputError, match="cannot be written"):
        write_obj(tmp_path / "missing" / "a.obj", square())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("cut", ["1/", "/1", "1/1/", "1/a", "1//1", "1/1234567890", "-/1"])
def test_a_corner_that_is_cut_short_is_named_with_its_line(tmp_path, cut):
    """As fuzzing once found it where a file ends."""
    text = TRIANGLE + "vt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 3/3 2/2 " + cut
    with pytest.raises(InputError, match="line 8: expected"):
        read(tmp_path, text)


def test_a_byte_order_mark_is_passed_over(tmp_path):
    assert len(read(tmp_path, "\ufeff" + TRIANGLE + "f 1 2 3\n").polygons) == 1


def test_a_finish_that_is_not_the_usual_one_is_written_where_it_is_used(tmp_path):
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    grey = {finish.name: finish.toned(0) for finish in (FINISHES[Material.TONGUE], FINISHES[Material.GUMS])}
    write_obj(tmp_path / "a.obj", mesh, others=grey, materials=np.array([Material.TONGUE]))
    text = (tmp_path / "a.mtl").read_text()
    assert "newmtl tongue\nKa 1 1 1\nKd 0.5294 0.5294 0.5294\n" in text and "gums" not in text
