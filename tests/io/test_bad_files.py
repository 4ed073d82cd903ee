"""What no reader may accept, whatever its format, and random damage to good files of each."""

import json
import os
import resource
import zipfile
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from trimesh.exchange.ply import export_ply
from trimesh.exchange.stl import export_stl_ascii

from caricli.errors import InputError
from caricli.io import image as image_module
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.io.config import read_config
from caricli.io.face import read_face, write_face
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.io.meshes.mesh import MESH_SUFFIXES, read_mesh, write_mesh
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.npz import read_npz
from caricli.io.strict_json import read_json
from caricli.io.takes.cues import read_cues
from caricli.structures import Face, Landmarks, Mesh


@dataclass(frozen=True)
class Settings:
    steps: int = 3
    rate: float = 0.1
    widths: tuple[int, ...] = (1, 2)


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.25]])
QUAD = np.array([[0, 1, 2, 3]], np.int32)
MESH = Mesh(CORNERS, QUAD, CORNERS[:, :2], QUAD)
TRIANGLES = trimesh.Trimesh(MESH.vertices, MESH.faces, process=False)
FACE = Face(Mesh(CORNERS, np.array([[0, 1, 2], [0, 2, 3]])), latent=np.arange(3.0), model_id="pca")
MARKS = Landmarks(np.stack([np.arange(68.0), np.arange(68.0) ** 2], axis=1), (5000, 5000))
PICTURE = np.arange(8 * 8 * 3, dtype=np.uint8).reshape(8, 8, 3)

CUES = '<rhubarbResult><mouthCues><mouthCue start="0" end="1">A</mouthCue></mouthCues></rhubarbResult>'

# The reader of every format, and what writes a good file of it to a path.
FORMATS = {
    **{f"mesh{suffix}": (read_mesh, lambda path: write_mesh(path, MESH)) for suffix in MESH_SUFFIXES},
    "text.ply": (read_mesh, lambda path: path.write_bytes(export_ply(TRIANGLES, encoding="ascii"))),
    "text.stl": (read_mesh, lambda path: path.write_text(export_stl_ascii(TRIANGLES))),
    "face.obj": (read_face, lambda path: write_obj(path, MESH)),
    "face.npz": (read_face, lambda path: write_face(path, FACE)),
    "arrays.npz": (read_npz, lambda path: np.savez(path, x=np.arange(4.0), y=np.array("text"))),
    "landmarks.json": (read_landmarks, lambda path: write_landmarks(path, MARKS)),
    "landmarks.pts": (read_landmarks, lambda path: write_landmarks(path, MARKS)),
    "landmarks.txt": (read_landmarks, lambda path: write_landmarks(path, MARKS)),
    "landmarks.npy": (read_landmarks, lambda path: write_landmarks(path, MARKS)),
    "picture.png": (read_image, lambda path: write_png(path, PICTURE)),
    "picture.jpg": (read_image, lambda path: Image.fromarray(PICTURE).save(path)),
    "cues.tsv": (read_cues, lambda path: path.write_text("0.00\tX\n0.20\tA\n0.31\tE\n")),
    "cues.xml": (read_cues, lambda path: path.write_text(CUES)),
    "value.json": (read_json, lambda path: path.write_text('{"a": [1, 2.5, null, true, "x"], "b": {}}')),
    "settings.yaml": (
        lambda path: read_config(path, Settings),
        lambda path: path.write_text("steps: 4\nrate: 1e-3\nwidths: [1, 2]\n"),
    ),
    "model.safetensors": (
        read_checkpoint,
        lambda path: write_checkpoint(path, {"x": np.arange(3.0)}, {"kind": "pca"}),
    ),
}
READERS = {name: reader for name, (reader, _) in FORMATS.items()}
BINARY = bytes(range(256)) * 4


@pytest.fixture(scope="module")
def good_files(tmp_path_factory):
    """A folder with one good file for every reader."""
    folder = tmp_path_factory.mktemp("good")
    for name, (_, write) in FORMATS.items():
        write(folder / name)
    return folder


def refused(reader, path):
    with pytest.raises(InputError) as caught:
        reader(path)
    message = str(caught.value)
    assert "\n" not in message and path.name in message and "expected" in message
    return message


@pytest.mark.parametrize("name", READERS)
def test_good_files_are_read(good_files, name):
    assert READERS[name](good_files / name) is not None


@pytest.mark.parametrize("name", READERS)
def test_unusable_paths(tmp_path, name):
    path = tmp_path / name
    assert "found no such file" in refused(READERS[name], path)
    path.touch()
    assert "found an empty file" in refused(READERS[name], path)
    path.unlink()
    path.mkdir()
    assert "found a folder" in refused(READERS[name], path)
    path.rmdir()
    path.symlink_to(path)
    assert "cannot be read" in refused(READERS[name], path)
    path.unlink()
    os.mkfifo(path)
    assert "not a regular file" in refused(READERS[name], path)
    assert "cannot be read" in refused(READERS[name], tmp_path / ("x" * 300 + name))
    with pytest.raises(InputError, match="cannot be read: embedded null byte"):
        READERS[name](f"{path}\0{path.suffix}")


@pytest.mark.parametrize("name", READERS)
def test_files_without_permission(good_files, monkeypatch, name):
    def deny(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("builtins.open", deny)
    assert "cannot be read: Permission denied" in refused(READERS[name], good_files / name)


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize(
    "data",
    [
        b"<!DOCTYPE html>\n<html><head><title>404</title></head><body>Not found</body></html>\n",
        BINARY,
        bytes(1000),
        b"\x80\x04\x95\x10\x00\x00\x00\x00\x00\x00\x00]\x94.",
        b"\x1f\x8b\x08\x00" + BINARY,
        "v 1 2 3\n".encode("utf-16"),
        b"\xff\xfe\xfd\n" * 100,
        b"PK\x03\x04" + BINARY,
        b"PK\x05\x06" + bytes(18),
        b"\x93NUMPY" + BINARY,
        b"\x89PNG\r\n\x1a\n" + BINARY,
        b"hello world\n",
    ],
    ids=["html", "binary", "zeros", "pickle", "gzip", "utf16", "bytes", "zip", "empty zip", "npy", "png", "text"],
)
def test_rubbish(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    refused(READERS[name], tmp_path / name)


def test_names_with_control_characters_stay_on_one_line(tmp_path):
    with pytest.raises(InputError) as caught:
        read_json(tmp_path / "a\nb\x1b[31m\udcff.json")
    assert str(caught.value).isprintable()
    str(caught.value).encode("utf-8")


@contextmanager
def little_memory(extra_bytes):
    """Let the process grow by no more than this."""
    with open("/proc/self/statm", encoding="ascii") as stream:
        size = int(stream.read().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (size + extra_bytes, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def survives(reader, path, data):
    path.write_bytes(data)
    try:
        with little_memory(2**28):
            reader(path)
    except InputError as error:
        assert "\n" not in str(error) and path.name in str(error)


FUZZ = settings(max_examples=60, deadline=None, derandomize=True)


@pytest.mark.parametrize("name", READERS)
def test_random_bytes(tmp_path_factory, name):
    path = tmp_path_factory.mktemp("random") / name

    @FUZZ
    @given(
        prefix=st.sampled_from(
            [
                b"",
                b"ply\n",
                b"solid ",
                b"glTF\2\0\0\0",
                b"PK\x03\x04",
                b"\x93NUMPY\1\0",
                b"\x89PNG\r\n\x1a\n",
                b"{",
                b"v 1 2 3\nf ",
            ]
        ),
        data=st.binary(max_size=200),
    )
    def check(prefix, data):
        survives(READERS[name], path, prefix + data)

    check()


EDITS = st.lists(
    st.tuples(
        st.floats(0, 1),
        st.integers(0, 12),
        st.binary(max_size=6)
        | st.sampled_from(
            [b"nan", b"1e308", b"-1", b"0", b"\xff\xff\xff\xff", b"\0\0\0\0", b"\n", b'"', b"[", b"{", b"9" * 12, b" "]
        ),
    ),
    min_size=1,
    max_size=5,
)


@pytest.mark.parametrize("name", READERS)
def test_damaged_good_files(good_files, tmp_path_factory, monkeypatch, name):
    good = (good_files / name).read_bytes()
    path = tmp_path_factory.mktemp("damaged") / name
    # A damaged header may honestly claim a picture below the real cap; decoding such ones is only slow.
    monkeypatch.setattr(image_module, "MAX_IMAGE_PIXELS", 100_000)

    @settings(FUZZ, max_examples=120)
    @given(edits=EDITS, keep=st.floats(0, 1) | st.just(1.0))
    def check(edits, keep):
        data = good
        for place, length, new in edits:
            at = int(place * len(data))
            data = data[:at] + new + data[at + length :]
        survives(READERS[name], path, data[: max(1, int(keep * len(data)))])

    check()


WORDS = st.sampled_from(
    [
        "v",
        "vt",
        "vn",
        "f",
        "g",
        "#",
        "\\",
        "0",
        "1",
        "2",
        "3",
        "4",
        "-1",
        "-2",
        "-9",
        "1/1",
        "2/2",
        "3/1",
        "1//1",
        "2//",
        "3/2/1",
        "/",
        "1e5",
        "1e7",
        "nan",
        "0.5",
        "x",
        "\r",
    ]
)


def test_random_objs(tmp_path_factory):
    path = tmp_path_factory.mktemp("objs") / "mesh.obj"
    start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 1\n"
    lines = st.one_of(
        st.lists(WORDS, max_size=7).map(" ".join),
        st.lists(WORDS, min_size=3, max_size=5).map(lambda words: "f " + " ".join(words)),
    )

    @settings(FUZZ, max_examples=400)
    @given(lines=st.lists(lines, max_size=4), ending=st.sampled_from(["\n", "\r\n", "\\\n"]))
    def check(lines, ending):
        survives(read_obj, path, (start + ending.join(lines)).encode())

    check()


def test_random_array_headers(tmp_path_factory):
    path = tmp_path_factory.mktemp("headers") / "arrays.npz"
    descr = st.sampled_from(["'<f8'", "'|O'", "'<U9'", "'|S0'", "'<f16'", "'>i4'", "'|b1'", "[('a', 'O')]", "'x'", "8"])
    side = st.sampled_from([0, 1, 2, 3, -1, 2**31, 2**63, 10**30])

    @settings(FUZZ, max_examples=200)
    @given(
        descr=descr,
        shape=st.lists(side, max_size=4),
        data=st.binary(max_size=80),
        compress=st.booleans(),
        order=st.sampled_from(["True", "False", "None"]),
    )
    def check(descr, shape, data, compress, order):
        text = f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {tuple(shape)}, }}".encode()
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED) as archive:
            archive.writestr("x.npy", b"\x93NUMPY\1\0" + len(text).to_bytes(2, "little") + text + data)
        survives(read_npz, path, path.read_bytes())

    check()


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=2), inner, max_size=3),
    max_leaves=6,
)


def test_random_model_headers(tmp_path_factory):
    path = tmp_path_factory.mktemp("models") / "model.safetensors"
    number = st.sampled_from([0, 1, 2, 4, 8, -1, 2**40, 10**30]) | VALUES
    entry = st.fixed_dictionaries(
        {
            "dtype": st.sampled_from(["F32", "F16", "BOOL", "BF16"]) | VALUES,
            "shape": st.lists(number, max_size=3) | VALUES,
            "data_offsets": st.lists(number, min_size=2, max_size=2) | VALUES,
        }
    )
    header = st.fixed_dictionaries(
        {"__metadata__": st.just({"caricli": "{}"}) | VALUES}, optional={"x": entry | VALUES, "y": entry}
    )

    @settings(FUZZ, max_examples=200)
    @given(header=header, data=st.sampled_from([b"", bytes(4), bytes(8), b"\xff" * 8]))
    def check(header, data):
        text = json.dumps(header).encode()
        survives(read_checkpoint, path, len(text).to_bytes(8, "little") + text + data)

    check()


def test_random_landmark_values(tmp_path_factory):
    path = tmp_path_factory.mktemp("values") / "landmarks.json"
    start = {"schema": "caricli.landmarks/1", "scheme": "ibug68", "points": [[k, k * k] for k in range(68)]}

    @settings(FUZZ, max_examples=150)
    @given(
        changes=st.dictionaries(st.sampled_from(["schema", "scheme", "image", "points"]), VALUES),
        places=st.dictionaries(st.integers(0, 67), VALUES, max_size=3),
        size=st.none() | st.fixed_dictionaries({"width": VALUES, "height": VALUES}),
    )
    def check(changes, places, size):
        points = [places.get(k, point) for k, point in enumerate(start["points"])]
        survives(read_landmarks, path, json.dumps({**start, "points": points, "image": size, **changes}).encode())

    check()
