import zipfile

import numpy as np
import pytest
from PIL import Image

from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import write_checkpoint
from caricli.io.face import write_face
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.mesh import write_mesh
from caricli.io.npz import read_npz, write_npz
from caricli.io.rig import write_rig
from caricli.io.strict_json import write_json
from caricli.models.landmark_map.model import LandmarkMap
from caricli.models.pca.model import PcaModel
from caricli.store.any_file import files_beside, load_acquaintances, load_any
from caricli.structures import Directions, Face, Landmarks, Mesh, Rig, Track
from tests.written_weights import write_weights


@pytest.fixture
def small(ball):
    vertices, faces = ball
    return Mesh((0.1 * vertices).astype(np.float32), faces)


@pytest.fixture
def rig(small):
    return Rig(("jawOpen",), small, np.ones((1, 300, 3), np.float32))


@pytest.fixture
def marks():
    return Landmarks(np.random.default_rng(0).uniform(0, 100, (68, 2)), (100, 100))


@pytest.fixture
def misnamed(tmp_path):
    """Give a file a name without a suffix, so that only its content tells what it is."""

    def rename(path):
        return path.rename(tmp_path / f"content-{path.suffix[1:]}")

    return rename


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".glb", ".gltf"])
def test_meshes(small, suffix, tmp_path):
    path = tmp_path / f"ball{suffix}"
    write_mesh(path, small)
    mesh = load_any(path)
    assert isinstance(mesh, Mesh) and len(mesh.faces) == 596


def test_faces_rigs_and_tracks_by_content(small, rig, misnamed, tmp_path):
    write_face(tmp_path / "face.npz", Face(small))
    write_rig(tmp_path / "rig.npz", rig)
    write_gltf(tmp_path / "rig.glb", rig)
    write_gltf(tmp_path / "rig.gltf", rig)
    write_weights(tmp_path / "take.json", Track(("jawOpen",), np.arange(3) / 30, np.zeros((3, 1))))
    write_npz(tmp_path / "take.npz", {"names": np.array(["jawOpen"]), "weights": np.zeros((3, 1))})
    assert isinstance(load_any(tmp_path / "face.npz"), Face)
    assert isinstance(load_any(tmp_path / "take.npz"), Track)
    for name, kind in (("rig.npz", Rig), ("rig.glb", Rig), ("rig.gltf", Rig), ("take.json", Track)):
        assert isinstance(load_any(misnamed(tmp_path / name)), kind), name


@pytest.mark.parametrize("suffix", [".json", ".pts", ".txt", ".npy"])
def test_landmarks(marks, suffix, tmp_path):
    write_landmarks(tmp_path / f"marks{suffix}", marks)
    loaded = load_any(tmp_path / f"marks{suffix}")
    assert isinstance(loaded, Landmarks)
    np.testing.assert_allclose(loaded.points, marks.points)


def test_what_comes_with_caricli():
    assert isinstance(load_any(asset_path("pca.safetensors")), PcaModel)
    assert isinstance(load_any(asset_path("landmark_map.safetensors")), LandmarkMap)
    assert isinstance(load_any(asset_path("directions-pca.npz")), Directions)


def test_expressions_and_pictures(tmp_path):
    assert "neutral" in load_any(asset_path("expressions.yaml"))
    (tmp_path / "set.json").write_text('{"neutral": {}, "smile": {"mouthSmile": 0.9}}')
    assert load_any(tmp_path / "set.json")["smile"] == {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9}
    write_png(tmp_path / "photo.png", np.zeros((4, 6, 3), np.uint8))
    assert load_any(tmp_path / "photo.png").shape == (4, 6, 3)
    for suffix in ("webp", "bmp", "tif", "gif", "jpg"):
        Image.new("RGB", (6, 4)).save(tmp_path / f"photo.{suffix}")
        assert load_any(tmp_path / f"photo.{suffix}").shape == (4, 6, 3)


def test_reports(tmp_path):
    write_json(tmp_path / "face.json", {"command": "refine", "version": "1"})
    assert load_any(tmp_path / "face.json")["command"] == "refine"


def test_live_link(tmp_path):
    (tmp_path / "take").write_text("Timecode,BlendShapeCount\n")
    with pytest.raises(InputError, match="take: line 1: expected the columns"):
        load_any(tmp_path / "take")


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.png", b"\x89PNG\r\n\x1a\n" + bytes(9), "a.png"),
        ("a.pdf", b"%PDF-1.4", "found a PDF document"),
        ("a.yaml", b"colour: 1\n", "a.yaml"),
        ("a.bin", bytes(64), "found binary data"),
        ("a.md", b"Dear reader\n", "found other text"),
        ("a.usdc", b"PXR-USDC" + bytes(80), "found USD, which caricli writes and does not read"),
        ("a.usda", b"#usda 1.0\n(\n)\n", "found USD, which caricli writes and does not read"),
        ("a.obj", b"v 0 0 nan\n", "a.obj"),
        ("a.glb", b"glTF" + bytes(8), "a.glb"),
        ("a.npz", b"PK\x03\x04", "truncated"),
        ("a.npz", b"nothing", "expected an NPZ file"),
        ("a.ply", b"ply\nformat nonsense\n", "a.ply"),
        ("a.stl", b"solid x\n", "a.stl"),
        ("a.json", b'{"schema": "other/1"}', "of schema 'other/1'"),
        ("a.json", b'{"schema": ', "a.json"),
        ("a.json", b'{"colour": 1}', "a.json"),
        ("a.safetensors", (40).to_bytes(8, "little") + b'{"a": 1}', "a.safetensors"),
        ("empty", b"", "found an empty file"),
    ],
)
def test_other_and_damaged_files_are_refused(name, content, words, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError) as refused:
        load_any(tmp_path / name)
    assert name in str(refused.value) and words in str(refused.value)


def test_other_arrays_folders_and_nothing_are_refused(tmp_path):
    write_npz(tmp_path / "a.npz", {"colour": np.zeros(3)})
    with pytest.raises(InputError, match="found an NPZ with colour"):
        load_any(tmp_path / "a.npz")
    none = "found none of dataset.json, pictures.json, sketches.json, textures.json in it: "
    with pytest.raises(InputError, match=f"{none}it is another, of which a single file can be given, or its making"):
        load_any(tmp_path)
    with pytest.raises(InputError, match="found no such file"):
        load_any(tmp_path / "none")


def test_usd_is_told_from_arrays(tmp_path):
    path = tmp_path / "head.usdz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("head.usdc", b"PXR-USDC" + bytes(80))
        archive.writestr("SKIN.png", b"\x89PNG")
    with pytest.raises(InputError, match="usdz: expected a file that caricli reads, found USD, which caricli writes"):
        load_any(path)
    with pytest.raises(InputError, match="usdz: expected an NPZ file, found USD, which caricli writes and does not"):
        read_npz(path)


def test_what_lies_beside_a_file(small, tmp_path):
    (tmp_path / "skin.png").write_bytes(b"\x89PNG")
    uvs = Mesh(small.vertices, small.faces, np.zeros((1, 2)), np.zeros_like(small.faces))
    write_mesh(tmp_path / "face.obj", uvs, "skin.png")
    (tmp_path / "face.npz").write_bytes(b"PK")
    (tmp_path / "other.npz").write_bytes(b"PK")
    assert files_beside(tmp_path / "face.obj") == ["face.mtl", "face.npz", "skin.png"]
    assert files_beside(tmp_path) == []
    (tmp_path / "face.mtl").write_bytes(b"newmtl a\nmap_Kd ../secret.png\n")
    assert files_beside(tmp_path / "face.obj") == ["face.mtl", "face.npz"]


def test_bundled_models_are_known():
    around = load_acquaintances()
    assert {"pca", "kernel", "morphable"} <= set(around.models.values())
    assert around.head.topology_id == load_any(asset_path("pca.safetensors")).template.topology_id


def test_weights_of_no_schema_are_refused(tmp_path):
    for number, schema in enumerate([{}, [1], 3, None]):
        path = tmp_path / f"{number}.safetensors"
        write_checkpoint(path, {"a": np.zeros(1, np.float32)}, {"schema": schema})
        with pytest.raises(InputError, match="expected a model of schema"):
            load_any(path)


def test_a_picture_whose_name_is_too_long_for_any_file_is_not_beside(small, tmp_path):
    path = tmp_path / "ball.obj"
    write_mesh(path, small)
    path.write_text("mtllib ball.mtl\n" + path.read_text())
    (tmp_path / "ball.mtl").write_text(f"newmtl skin\nmap_Kd {300 * 'a'}.png\n")
    assert files_beside(path) == ["ball.mtl"]
