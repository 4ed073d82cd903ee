import dataclasses

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.npz import read_npz, write_npz
from caricli.io.rig import read_rig, write_rig
from caricli.structures import Camera, Depiction, Mesh, Mood, Rig
from caricli.structures.change_atlas import ChangeAtlas


@pytest.fixture
def full_rig(full_rig):
    normal = np.random.default_rng(5).normal(0, 0.003, (len(full_rig.names), 7, 3))
    actions = np.random.default_rng(6).random((len(full_rig.names), 52), np.float32)
    tiles = np.random.default_rng(7).integers(0, 255, (9, 12, 3), np.uint8)
    changes = ChangeAtlas(tiles, 4, 3, (0.1, 0.2, 0.8, 0.9), 0.5, 0.25)
    return dataclasses.replace(full_rig, normal_deltas=normal.astype(np.float32), actions=actions, changes=changes)


def parts(rig):
    """What a rig and its mesh hold, by name."""
    mesh = {field.name: getattr(rig.mesh, field.name) for field in dataclasses.fields(Mesh)}
    own = {name: getattr(rig, name) for name in ("names", "deltas", "materials", "normal_deltas", "actions")}
    own |= {"changes": rig.changes.picture, "change_layout": rig.changes.layout}
    return mesh | own | dict(rig.pictures.items())


def test_all_fields_come_back_exactly(full_rig, tmp_path):
    write_rig(tmp_path / "a.npz", full_rig)
    back = read_rig(tmp_path / "a.npz")
    for name, expected in parts(full_rig).items():
        value = parts(back)[name]
        assert type(value) is type(expected), name
        if isinstance(expected, np.ndarray):
            assert value.dtype == expected.dtype, name
        np.testing.assert_array_equal(value, expected, name)
    stored = read_npz(tmp_path / "a.npz")
    texts = [str(stored[key]) for key in ("schema", "units", "axes")]
    assert texts == ["caricli.rig/1", "m", "+y up, +z front"]


def test_what_is_none_is_absent(full_rig, tmp_path):
    bare = Rig(full_rig.names, Mesh(full_rig.neutral, full_rig.faces), full_rig.deltas)
    write_rig(tmp_path / "a.npz", bare)
    assert set(read_npz(tmp_path / "a.npz")) == {"schema", "units", "axes", "names", "neutral", "deltas", "faces"}
    back = read_rig(tmp_path / "a.npz")
    held = [field.name for field in dataclasses.fields(Rig) if getattr(back, field.name) is not None]
    assert held == ["names", "mesh", "deltas", "pictures", "moods"] and back.mesh.is_plain
    assert not back.pictures and back.moods == ()


def test_moods_come_back(full_rig, tmp_path):
    moods = (Mood("sad", full_rig.pictures.skin // 2), Mood("wütend", 255 - full_rig.pictures.skin))
    write_rig(tmp_path / "a.npz", dataclasses.replace(full_rig, moods=moods))
    back = read_rig(tmp_path / "a.npz")
    assert [mood.name for mood in back.moods] == ["sad", "wütend"]
    for mood, expected in zip(back.moods, moods, strict=True):
        np.testing.assert_array_equal(mood.skin, expected.skin)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"moods": np.array(["a"])}, "a name for every picture"),
        ({"moods": np.array([["a", "b"]])}, "a name for every picture"),
        ({"moods": np.array(["a", "a"])}, "distinct names"),
        ({"moods": np.array(["a", ""])}, "a name for every picture, found none"),
        ({"mood_textures": np.zeros((2, 4, 4, 3), np.uint8)}, "the skin's shape"),
        ({"mood_textures": np.zeros((2, 4), np.uint8)}, "expected .H,W,3. uint8"),
        ({"mood_textures": np.zeros((2, 4, 4, 3))}, "expected uint8"),
    ],
)
def test_moods_that_do_not_fit(change, words, full_rig, tmp_path):
    moods = (Mood("sad", full_rig.pictures.skin), Mood("happy", full_rig.pictures.skin))
    write_rig(tmp_path / "a.npz", dataclasses.replace(full_rig, moods=moods))
    write_npz(tmp_path / "b.npz", dict(read_npz(tmp_path / "a.npz")) | change)
    with pytest.raises(InputError, match=words):
        read_rig(tmp_path / "b.npz")


def test_a_head_that_keeps_still(full_rig, tmp_path):
    none = full_rig.deltas[:0]
    still = dataclasses.replace(full_rig, names=(), deltas=none, normal_deltas=None, actions=None)
    write_rig(tmp_path / "a.npz", still)
    back = read_rig(tmp_path / "a.npz")
    assert back.names == () and back.deltas.shape == (0, *full_rig.neutral.shape) and back.deltas.dtype == np.float32
    np.testing.assert_array_equal(back.neutral, full_rig.neutral)
    np.testing.assert_array_equal(back.pictures.skin, full_rig.pictures.skin)


def test_the_same_rig_gives_the_same_bytes(full_rig, tmp_path):
    for name in ("a", "b"):
        write_rig(tmp_path / f"{name}.npz", full_rig)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def bad(array, value, at=0):
    array = array.copy()
    array.flat[at] = value
    return array


CASES = [
    (lambda r: {"names": r.names[:3]}, "deltas: expected the shape (3, "),
    (lambda r: {"names": (*r.names[:3], "jawOpen")}, "distinct names"),
    (lambda r: {"names": (*r.names[:3], "")}, "distinct names"),
    (lambda r: {"neutral": bad(r.neutral, np.nan)}, "neutral: expected finite"),
    (lambda r: {"neutral": r.neutral[:, :2]}, "neutral: expected (V,3)"),
    (lambda r: {"deltas": bad(r.deltas, np.inf)}, "deltas: expected finite"),
    (lambda r: {"deltas": r.deltas[:, :-1]}, "deltas: expected the shape"),
    (lambda r: {"faces": bad(r.faces, 10**6)}, "faces: expected indices below"),
    (lambda r: {"uv_polygons": bad(r.mesh.uv_polygons, 10**6)}, "uv_polygons: expected indices below"),
    (lambda r: {"uvs": None}, "uvs: expected them together"),
    (lambda r: {"materials": bad(r.materials, 99)}, "materials: expected"),
    (lambda r: {"materials": r.materials[:-1]}, "materials: expected"),
    (lambda r: {"texture": r.pictures.skin[:, :, 0]}, "skin: expected (H,W,3) uint8"),
    (lambda r: {"eye_texture": r.pictures.eyes[:0]}, "eyes: expected (H,W,3) uint8"),
    (lambda r: {"normal_deltas": r.normal_deltas[:3]}, "normal_deltas: expected 4 displacements"),
    (lambda r: {"normal_deltas": r.normal_deltas[..., :2]}, "normal_deltas: expected 4 displacements"),
    (lambda r: {"normal_deltas": bad(r.normal_deltas, np.nan)}, "normal_deltas: expected finite coordinates"),
    (lambda r: {"actions": r.actions[:, :51]}, "actions: expected (4, 52), found (4, 51)"),
    (lambda r: {"actions": bad(r.actions, np.nan)}, "actions: expected finite"),
    (lambda r: {"changes": None}, "changes: expected them together with change_layout"),
    (lambda r: {"changes": r.changes.picture[:3]}, "changes: expected 10 tiles, found room for 4"),
    (lambda r: {"changes": r.changes.picture[..., 0]}, "changes: expected (H,W,3) uint8"),
    (lambda r: {"change_layout": r.changes.layout[:7]}, "change_layout: expected eight numbers"),
    (lambda r: {"change_layout": bad(r.changes.layout, np.nan, 6)}, "change_layout: expected eight numbers"),
    (lambda r: {"change_layout": bad(r.changes.layout, 99, 0)}, "changes: expected rows of tiles"),
    (lambda r: {"change_layout": bad(r.changes.layout, 2, 3)}, "changes: expected a window inside"),
    (lambda r: {"change_layout": bad(r.changes.layout, 1e6, 7)}, "changes: expected a gain and an offset"),
]


@pytest.mark.parametrize(("changes", "words"), CASES)
def test_a_bad_rig_is_not_read(full_rig, changes, words, tmp_path):
    changed = changes(full_rig)
    write_rig(tmp_path / "a.npz", full_rig)
    arrays = read_npz(tmp_path / "a.npz") | changed
    write_npz(tmp_path / "b.npz", {key: np.asarray(value) for key, value in arrays.items() if value is not None})
    with pytest.raises(InputError) as refused:
        read_rig(tmp_path / "b.npz")
    assert words in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"schema": np.array("caricli.face/1")}, "schema"),
        ({"units": None}, "units"),
        ({"names": None}, "with names, found none"),
        ({"more": np.zeros(3)}, "'more'"),
        ({"names": np.array("jawOpen")}, "names: expected"),
        ({"names": np.arange(4)}, "names: expected"),
        ({"neutral": np.zeros((96, 3), int)}, "neutral: expected float32"),
        ({"deltas": np.full((4, 96, 3), 1e300)}, "deltas: expected finite"),
        ({"faces": np.array([[0, 1, 2**32 + 2]])}, "faces: expected int32"),
        ({"texture": np.full((2, 2, 3), 300, np.uint16)}, "texture: expected uint8"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_bad_files_are_refused(full_rig, changes, words, tmp_path):
    write_rig(tmp_path / "a.npz", full_rig)
    arrays = read_npz(tmp_path / "a.npz") | changes
    write_npz(tmp_path / "b.npz", {key: value for key, value in arrays.items() if value is not None})
    with pytest.raises(InputError) as refused:
        read_rig(tmp_path / "b.npz")
    assert words in str(refused.value) and "\n" not in str(refused.value) and "b.npz" in str(refused.value)


def test_wider_numbers_that_fit_are_read(full_rig, tmp_path):
    write_rig(tmp_path / "a.npz", full_rig)
    arrays = read_npz(tmp_path / "a.npz")
    arrays |= {"faces": arrays["faces"].astype(np.int64), "deltas": arrays["deltas"].astype(np.float64)}
    write_npz(tmp_path / "b.npz", arrays)
    back = read_rig(tmp_path / "b.npz")
    assert (back.faces.dtype, back.deltas.dtype) == (np.int32, np.float32)
    np.testing.assert_array_equal(back.deltas, full_rig.deltas)


def test_how_a_picture_shows_it_comes_back(full_rig, tmp_path):
    camera = Camera(640.0, np.diag([1.0, -1.0, -1.0]), np.array([200.0, 180.5]))
    marks = np.random.default_rng(2).uniform(0, 300, (81, 2))
    shown = Depiction(camera, full_rig.neutral + np.float32(0.01), marks)
    write_rig(tmp_path / "a.npz", dataclasses.replace(full_rig, depiction=shown))
    back = read_rig(tmp_path / "a.npz").depiction
    assert back.camera.scale == 640 and back.vertices.dtype == np.float32
    np.testing.assert_array_equal(back.camera.translation, camera.translation)
    np.testing.assert_array_equal(back.camera.rotation, camera.rotation)
    np.testing.assert_array_equal(back.vertices, shown.vertices)
    np.testing.assert_array_equal(back.landmarks, marks)


def test_half_of_a_camera_is_refused(full_rig, tmp_path):
    camera = Camera(640.0, np.diag([1.0, -1.0, -1.0]), np.zeros(2))
    write_rig(tmp_path / "a.npz", dataclasses.replace(full_rig, depiction=Depiction(camera, full_rig.neutral)))
    whole = read_npz(tmp_path / "a.npz")
    for change, message in [
        ({"depicted": None}, "found only camera_scale"),
        ({"camera_scale": None}, "found only camera_rotation"),
        ({"depicted": whole["depicted"][1:]}, "depicted: expected"),
        ({"landmarks": np.zeros((5, 2))}, "landmarks: expected"),
        ({"camera_rotation": 2 * whole["camera_rotation"]}, "camera_rotation"),
    ]:
        write_npz(tmp_path / "b.npz", {k: v for k, v in (whole | change).items() if v is not None})
        with pytest.raises(InputError, match=message):
            read_rig(tmp_path / "b.npz")
