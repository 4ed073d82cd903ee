import shutil

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from caricli.cli import cli
from caricli.io.face import write_face
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import read_image, write_png
from caricli.io.meshes.mesh import read_mesh, write_mesh
from caricli.io.meshes.obj import write_obj
from caricli.io.rig import write_rig
from caricli.structures import Camera, Face, Mesh, Pictures, Rig

OCTAHEDRON = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]], np.int32)


@pytest.fixture
def obj(tmp_path):
    path = tmp_path / "head.obj"
    write_obj(path, Mesh(OCTAHEDRON * 0.1, FACES, None, None))
    return path


@pytest.fixture
def npz(tmp_path):
    path = tmp_path / "head.npz"
    camera = Camera(100.0, np.diag([1.0, -1, -1]), np.array([40.0, 25.0]))
    write_face(path, Face(Mesh(OCTAHEDRON * 0.1, FACES), camera))
    return path


def run(*args):
    return CliRunner().invoke(cli, ["render", *map(str, args)])


def drawn(picture):
    """Where a picture is darker than the paper."""
    return (picture < 205).any(-1)


def test_draws_the_views_of_one_face_in_a_row(obj, tmp_path):
    out = tmp_path / "deep" / "views.png"
    result = run(obj, "-o", out, "--size", 32, "--views", "front, profile")
    assert result.exit_code == 0, result.output
    assert str(out) in result.output
    picture = read_image(out)
    assert picture.shape[1] > 2 * 32 > picture.shape[0] >= 32
    half = picture.shape[1] // 2
    assert drawn(picture[:, :half]).sum() > 200 and drawn(picture[:, half:]).sum() > 200


def test_same_input_same_bytes(obj, tmp_path):
    for name in ("a.png", "b.png"):
        assert run(obj, "-o", tmp_path / name, "--size", 32).exit_code == 0
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def film_frames(path):
    film = cv2.VideoCapture(str(path))
    frames = []
    while (frame := film.read())[0]:
        frames.append(frame[1])
    return frames


TURN = ("--views", "turntable", "--size", 24)


def test_eyes_are_drawn_where_they_are_among_the_parts(npz, tmp_path, monkeypatch):
    """In a sheet and over a picture; the head has none of its own."""
    asked = []

    def place(*mesh):
        asked.append(mesh)
        return ()

    monkeypatch.setattr("caricli.render.face_look.place_eyeballs", place)
    write_png(tmp_path / "photo.png", np.full((60, 80, 3), 255, np.uint8))
    for words in (("--image", tmp_path / "photo.png"), ("--views", "front", "--size", 32)):
        drawn = []
        for parts in ("skin", "skin,eyes"):
            asked.clear()
            assert run(npz, "-o", tmp_path / "a.png", *words, "--parts", parts, "--overwrite").exit_code == 0
            drawn.append(bool(asked))
        assert drawn == [False, True]


def test_a_turn_as_a_strip(obj, tmp_path):
    assert run(obj, "-o", tmp_path / "turn.png", *TURN, "--frames", 6, "--columns", 6).exit_code == 0
    picture = read_image(tmp_path / "turn.png")
    assert picture.shape[1] > 6 * 24 and picture.shape[0] < 2 * 24


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_a_turn_as_a_film(obj, npz, tmp_path, suffix):
    one, again, both = (tmp_path / f"{name}{suffix}" for name in ("one", "again", "both"))
    for out, faces in ((one, [obj]), (again, [obj]), (both, [obj, npz])):
        result = run(*faces, "-o", out, *TURN, "--frames", 6)
        assert result.exit_code == 0, result.output
    assert one.read_bytes() == again.read_bytes()
    film, pair = (film_frames(path) for path in (one, both))
    assert len(film) == len(pair) == 6 and film[0].shape == (24, 24, 3)
    assert pair[0].shape[1] > 2 * 24
    # An octahedron turns by 60 degrees from one frame to the next: three are one half of a turn, and look alike.
    assert np.abs(film[1].astype(int) - film[0]).max() > 40
    assert np.abs(film[3].astype(int) - film[0]).mean() < 4


def test_several_faces_become_a_labelled_sheet(obj, npz, tmp_path):
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    assert run(obj, "-o", one, "--size", 64, "--views", "front").exit_code == 0
    assert run(obj, npz, obj, "-o", two, "--size", 64, "--views", "front", "--columns", 2).exit_code == 0
    single, sheet = read_image(one), read_image(two)
    assert sheet.shape[0] > 2 * single.shape[0] - 8 + 20  # room for labels
    assert not drawn(sheet[-70:, -64:]).any()  # the fourth place is empty


@pytest.mark.parametrize(
    ("places", "names"),
    [
        (["a/one.obj", "b/two.obj"], ["one", "two"]),
        (["heads/ann/textured/face.obj", "heads/bob/textured/face.obj"], ["ann", "bob"]),
        (["face.obj", "deep/ann/face.obj"], ["face", "deep/ann"]),
        (["take/face.obj", "take/face.ply"], ["face.obj", "face.ply"]),
        (["ann/face.obj", "bob/face.ply"], ["ann", "bob"]),
        (["face.obj", "face.obj"], ["face.obj", "face.obj"]),
    ],
)
def test_files_of_one_name_are_told_apart(places, names, obj, tmp_path, monkeypatch):
    paths = [tmp_path / place for place in places]
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_mesh(path, read_mesh(obj))
    labels = []

    def sheet(images, columns=None, given=None):
        labels.extend(given or [])
        return images[0]

    monkeypatch.setattr("caricli.render.sheets.face_sheet.contact_sheet", sheet)
    assert run(*paths, "-o", tmp_path / "sheet.png", "--views", "front", "--size", 16).exit_code == 0
    assert labels == names


GREEN = np.tile(np.array([20, 160, 40], np.uint8), (32, 32, 1))
BLUE = np.tile(np.array([30, 40, 200], np.uint8), (32, 32, 1))


@pytest.fixture(scope="module")
def painted(tmp_path_factory):
    """Files by name of one octahedron with a green skin, its lowest two sides of a blue eye."""
    folder = tmp_path_factory.mktemp("painted")
    uvs = np.random.default_rng(0).uniform(0.2, 0.8, (24, 2))
    mesh = Mesh(OCTAHEDRON.astype(np.float32) * 0.1, FACES, uvs, np.arange(24, dtype=np.int32).reshape(8, 3))
    materials = np.array([0, 0, 1, 1, 0, 0, 1, 1], np.int32)
    deltas = np.zeros((1, 6, 3), np.float32)
    deltas[0, 0] = 0.01
    rig = Rig(("jawOpen",), mesh, deltas, materials, Pictures(GREEN, BLUE))
    write_rig(folder / "rig.npz", rig)
    write_gltf(folder / "rig.glb", rig)
    plain = Rig((), mesh, deltas[:0], pictures=Pictures(GREEN))
    write_gltf(folder / "face.glb", plain)
    write_png(folder / "skin.png", GREEN)
    write_mesh(folder / "face.obj", mesh, "skin.png", folder / "face.mtl")
    write_face(folder / "face.npz", Face(mesh))
    return folder


@pytest.mark.parametrize("name", ["rig.npz", "rig.glb", "face.glb", "face.obj", "face.npz"])
def test_draws_what_they_wear(painted, tmp_path, name):
    result = run(painted / name, "-o", tmp_path / "a.png", "--size", 64, "--views", "front")
    assert result.exit_code == 0, result.output
    picture = read_image(tmp_path / "a.png").astype(int)
    colours = picture[drawn(picture)]
    top = picture[20:28][drawn(picture[20:28])].mean(0)
    low = picture[-28:-20][drawn(picture[-28:-20])].mean(0)
    assert len(colours) > 500 and top.argmax() == 1 and low.argmax() == (2 if name.startswith("rig") else 1)


def test_a_mesh_without_pictures_is_clay(painted, tmp_path):
    path = tmp_path / "alone.obj"
    write_mesh(path, read_mesh(painted / "face.obj"))
    assert run(path, "-o", tmp_path / "a.png", "--size", 64, "--views", "front").exit_code == 0
    picture = read_image(tmp_path / "a.png").astype(int)
    assert picture[drawn(picture)].mean(0).argmax() == 0


def test_a_picture_that_is_named_and_not_there_is_said(painted, tmp_path):
    shutil.copy(painted / "face.obj", tmp_path)
    shutil.copy(painted / "face.mtl", tmp_path)
    code, said = failure(tmp_path / "face.obj", "-o", tmp_path / "a.png")
    assert code == 1 and "skin.png" in said and not (tmp_path / "a.png").exists()


def test_lays_a_face_over_its_picture(npz, tmp_path):
    write_png(tmp_path / "photo.png", np.full((60, 80, 3), 255, np.uint8))
    result = run(npz, "-o", tmp_path / "over.png", "--image", tmp_path / "photo.png")
    assert result.exit_code == 0, result.output
    picture = read_image(tmp_path / "over.png")
    assert picture.shape == (60, 80, 3)
    y, x = np.nonzero((picture != 255).any(-1))
    np.testing.assert_allclose([x.mean(), y.mean()], [40, 25], atol=0.3)


@pytest.mark.parametrize("options", [["--views", "front"], ["--size", 64], ["--columns", 2], ["--views", "turntable"]])
def test_an_overlay_has_the_size_and_side_of_its_picture(options, npz, tmp_path):
    write_png(tmp_path / "photo.png", np.zeros((9, 9, 3), np.uint8))
    code, said = failure(npz, "-o", tmp_path / "over.png", "--image", tmp_path / "photo.png", *options)
    assert code == 2 and "as large as IMAGE is" in said and not (tmp_path / "over.png").exists()


def failure(*args):
    result = run(*args)
    assert result.output.count("\n") == 1, result.output
    return result.exit_code, result.output


def test_an_overlay_needs_a_camera(obj, tmp_path):
    write_png(tmp_path / "photo.png", np.zeros((9, 9, 3), np.uint8))
    code, said = failure(obj, "-o", tmp_path / "over.png", "--image", tmp_path / "photo.png")
    assert code == 1 and "head.obj" in said and "camera" in said
    assert not (tmp_path / "over.png").exists()


def test_refuses_what_exists_what_is_missing_and_what_is_too_much(obj, tmp_path):
    out = tmp_path / "x.png"
    out.write_text("mine")
    code, said = failure(obj, "-o", out)
    assert code == 1 and "--overwrite" in said and out.read_text() == "mine"
    assert failure(tmp_path / "none.obj", "-o", tmp_path / "y.png")[0] == 1
    code, said = failure(obj, "-o", obj, "--overwrite")
    assert code == 2 and "head.obj" in said
    code, said = failure(obj, "-o", tmp_path / "y.png", "--size", 4096, "--views", "turntable", "--frames", 360)
    assert code == 2 and "--size" in said
    assert not (tmp_path / "y.png").exists()
    assert run(obj, "-o", out, "--size", 16, "--overwrite").exit_code == 0
    assert read_image(out).ndim == 3


@pytest.mark.parametrize(
    "options", [["--views", "above"], ["--size", "0"], ["--frames", "0"], ["--frames", "3"], ["--image", "a", "b"]]
)
def test_wrong_usage_is_exit_2(obj, tmp_path, options):
    assert run(obj, "-o", tmp_path / "x.png", *options).exit_code == 2


@pytest.mark.parametrize("parts", ["skin,beard", "teeth", ""])
def test_parts_that_no_head_has_are_wrong_usage(obj, tmp_path, parts):
    code, said = failure(obj, "-o", tmp_path / "a.png", "--parts", parts)
    assert code == 2 and "--parts" in said and not (tmp_path / "a.png").exists()
