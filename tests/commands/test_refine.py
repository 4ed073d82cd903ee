import io
import struct
import zlib
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image

from caricli.io.face import read_face, write_face
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.strict_json import read_json, write_json
from caricli.methods.faces.encode_face import decode_face, encode_face
from caricli.store.models import load_model
from caricli.structures import Camera, Face, Landmarks

COMMAND = "refine"
NAMES = ["refined.json", "refined.npz", "refined.obj", "refined.png"]
WIDTH, HEIGHT = 400, 440
CAMERA = Camera(1400.0, np.diag([1.0, -1, -1]), np.array([200.0, 400.0]))


@pytest.fixture(scope="module")
def model():
    return load_model(kind="intrinsic")


@pytest.fixture(scope="module")
def wanted(head, model):
    """68 landmarks of someone who is not the template, in the camera of the coarse face."""
    note = model.template.annotation
    face = head.evaluate(gender=0.1, age=0.8, actions={"mouthSmileLeft": 0.7, "mouthSmileRight": 0.7})
    return CAMERA.project(face[note.landmarks[:68]])


@pytest.fixture(scope="module")
def coarse(model, tmp_path_factory):
    """The template as a face with a latent, its camera and fitted landmarks."""
    path, template = tmp_path_factory.mktemp("coarse") / "face.npz", model.template
    marks = CAMERA.project(template.vertices[template.annotation.landmarks[:68]])
    write_face(path, encode_face(Face(template, CAMERA, marks), model))
    return path


@pytest.fixture
def landmarks(wanted, tmp_path):
    path = tmp_path / "landmarks.json"
    write_landmarks(path, Landmarks(wanted, (WIDTH, HEIGHT)))
    return path


@pytest.fixture(scope="module")
def photo(tmp_path_factory):
    path = tmp_path_factory.mktemp("photo") / "photo.png"
    write_png(path, np.full((HEIGHT, WIDTH, 3), (40, 90, 200), np.uint8))
    return path


def label_map(wanted, factor=1.0):
    """CelebAMask-HQ's labels of the eyes, drawn between their landmarks."""
    labels = np.ones((HEIGHT, WIDTH), np.uint8)
    for number, eye in ((4, wanted[36:42]), (5, wanted[42:48])):
        outline = eye.mean(0) + factor * (eye - eye.mean(0))
        cv2.fillPoly(labels, [np.round(outline).astype(np.int32)], number)
    return labels


@pytest.fixture(scope="module")
def refined(run, coarse, wanted, photo, tmp_path_factory):
    """The folder that the command made."""
    folder = tmp_path_factory.mktemp("refined")
    write_landmarks(folder / "marks.json", Landmarks(wanted, (WIDTH, HEIGHT)))
    out = folder / "out" / "refined.obj"
    result = run(COMMAND, coarse, folder / "marks.json", "--image", photo, "--out", out)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{out}: NME ") and result.stdout.count("\n") == 1
    return folder / "out"


def test_four_files_that_agree(refined, coarse, wanted, model):
    assert sorted(path.name for path in refined.iterdir()) == NAMES
    mesh, face, report = (read_obj(refined / NAMES[2]), read_face(refined / NAMES[1]), read_json(refined / NAMES[0]))
    before = read_face(coarse)
    np.testing.assert_allclose(mesh.vertices, face.vertices, atol=1e-7)
    np.testing.assert_array_equal(mesh.polygons, before.mesh.polygons)
    np.testing.assert_array_equal(face.mesh.uv_polygons, before.mesh.uv_polygons)
    assert (face.camera.scale, face.model_id) == (before.camera.scale, before.model_id)
    np.testing.assert_array_equal(face.camera.rotation, before.camera.rotation)
    np.testing.assert_array_equal(face.camera.translation, before.camera.translation)
    diagonal = np.linalg.norm(np.ptp(wanted, axis=0))
    nme = 100 * np.linalg.norm(face.landmarks - wanted, axis=1).mean() / diagonal
    assert nme == pytest.approx(report["after"]["all"], rel=1e-3) and nme <= 0.3 < report["before"]["all"]
    assert report["after"]["eyes"] <= report["before"]["eyes"] / 10 and report["flipped"] <= 0.001
    moved = np.linalg.norm(face.vertices - before.vertices, axis=1).max()
    assert report["moved"] == pytest.approx(moved, rel=1e-3)
    assert report["command"] == COMMAND and report["model_id"] == model.model_id and report["snapped"] == 0
    assert len(report["inputs"]) == 3


def test_the_latent_stays_and_the_residual_gives_the_face_back(refined, coarse, model, run, tmp_path):
    face, before = read_face(refined / NAMES[1]), read_face(coarse)
    np.testing.assert_array_equal(face.latent, before.latent)
    shift = face.vertices.mean(0) - model.decode(face.latent).mean(0)
    np.testing.assert_allclose(decode_face(face, model, shift).vertices, face.vertices, atol=1e-6)
    # The next command starts from what was refined.
    out = tmp_path / "same.obj"
    result = run("edit-semantic", refined / NAMES[1], "--model", "intrinsic", "--label", "BigNose=0", "--out", out)
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(read_face(tmp_path / "same.npz").vertices, face.vertices, atol=2e-6)


def test_the_picture_shows_before_and_after(refined, photo):
    sheet = read_image(refined / NAMES[3]).astype(int)
    height = len(sheet) // 2
    blue = [(np.abs(half - (40, 90, 200)).sum(-1) < 20).sum() for half in (sheet[:height], sheet[height:])]
    assert min(blue) > 2000
    assert np.abs(sheet[:height] - sheet[-height:]).max() > 50


def test_the_landmarks_it_has_change_nothing(run, coarse, tmp_path):
    face = read_face(coarse)
    write_landmarks(tmp_path / "own.json", Landmarks(face.landmarks, (WIDTH, HEIGHT)))
    result = run(COMMAND, coarse, tmp_path / "own.json", "--out", tmp_path / "refined.obj")
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(read_face(tmp_path / "refined.npz").vertices, face.vertices, atol=1e-6)


@pytest.mark.parametrize("edited", [False, True])
def test_it_is_said_where_an_edited_face_goes_back(edited, run, coarse, landmarks, tmp_path):
    face = read_face(coarse)
    write_face(tmp_path / "face.npz", face.with_vertices(face.vertices * [1.3 if edited else 1, 1, 1]))
    result = run(COMMAND, tmp_path / "face.npz", landmarks, "--out", tmp_path / "refined.obj")
    assert result.exit_code == 0, result.output
    words = "face.npz: was edited after it was fitted: landmarks are up to "
    assert (words in result.stderr) == ("goes back onto its picture" in result.stderr) == edited


def test_a_face_without_latent_stays_without(run, coarse, landmarks, tmp_path):
    bare = replace(read_face(coarse), latent=None, residual=None, model_id=None, landmarks=None)
    write_face(tmp_path / "bare.npz", bare)
    options = ("--laplacian", "uniform", "--weight", 100, "--subdivide", 1, "--out", tmp_path / "refined.obj")
    result = run(COMMAND, tmp_path / "bare.npz", landmarks, *options)
    assert result.exit_code == 0, result.output
    face, report = read_face(tmp_path / "refined.npz"), read_json(tmp_path / "refined.json")
    assert face.latent is face.residual is face.model_id is None and len(face.vertices) == 4200
    assert len(read_obj(tmp_path / "refined.obj").vertices) > 12000
    assert (report["laplacian"], report["weight"], report["subdivide"]) == ("uniform", 100, 1)


def test_eyes_snap_to_the_parsing(run, coarse, landmarks, wanted, tmp_path):
    labels = label_map(wanted, 1.3)
    Image.fromarray(labels).save(tmp_path / "labels.png")
    out = tmp_path / "refined.obj"
    result = run(COMMAND, coarse, landmarks, "--parsing", tmp_path / "labels.png", "--weight", 100, "--out", out)
    assert result.exit_code == 0, result.output
    assert read_json(tmp_path / "refined.json")["snapped"] == 12
    found = read_face(tmp_path / "refined.npz").landmarks
    border = np.argwhere((labels > 1) & (cv2.erode(labels, np.ones((3, 3))) == 1))[:, ::-1]
    away = [np.linalg.norm(marks[36:48, None] - border, axis=2).min(1).max() for marks in (wanted, found)]
    assert away[1] < 1 < away[0]
    # The same numbers under other names, and eyes that only the legend knows.
    write_json(tmp_path / "labels.json", {"schema": "caricli.parsing/1", "labels": {"eye_left": 4}})
    result = run(COMMAND, coarse, landmarks, "--parsing", tmp_path / "labels.png", "--out", out, "--overwrite")
    assert result.exit_code == 0, result.output
    assert read_json(tmp_path / "refined.json")["snapped"] == 6


def bomb():
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


def changed(wanted, **places):
    """Landmarks, some of them elsewhere: ``_37=(x, y)``."""
    points = wanted.copy()
    for name, place in places.items():
        points[int(name[1:])] = place
    return points


BAD_MARKS = {
    "far outside": (lambda w: w + [3000, 0], "expected "),
    "one far outside": (lambda w: changed(w, _8=(200, 5000)), "point 8: expected a place in or near"),
    "of another picture": (lambda w: 0.2 * w, "landmarks of the picture that the face was fitted to"),
    "lids crossed": (lambda w: changed(w, _37=w[41] + [0, 9], _41=w[37] - [0, 9]), "landmarks 37 and 41: expected"),
    "coincident": (lambda w: changed(w, _30=w[33]), "found 30 and 33 in one"),
}


@pytest.mark.parametrize("case", BAD_MARKS)
def test_bad_landmarks(case, refused, coarse, wanted, tmp_path):
    change, words = BAD_MARKS[case]
    np.save(tmp_path / "marks.npy", change(wanted))
    write_png(tmp_path / "photo.png", np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    out = tmp_path / "out" / "refined.obj"
    said = refused(COMMAND, coarse, tmp_path / "marks.npy", "--image", tmp_path / "photo.png", "--out", out)
    assert words in said and "marks.npy" in said
    assert not out.parent.exists()


def test_landmarks_of_a_picture_of_another_size(refused, coarse, wanted, photo, tmp_path):
    write_landmarks(tmp_path / "marks.json", Landmarks(wanted, (WIDTH, HEIGHT + 20)))
    out = tmp_path / "out" / "refined.obj"
    said = refused(COMMAND, coarse, tmp_path / "marks.json", "--image", photo, "--out", out)
    assert "expected landmarks of the 400 x 440 picture" in said and not out.parent.exists()


def png(array):
    stream = io.BytesIO()
    Image.fromarray(array).save(stream, "PNG")
    return stream.getvalue()


BAD_PARSING = {
    "another size": (lambda labels: png(labels[:-1]), "expected the picture's size, 400 x 440, found 400 x 439"),
    "no eyes": (lambda labels: png(np.minimum(labels, 1)), "expected pixels labelled eye_left or eye_right"),
    "colours": (lambda labels: png(np.stack([labels, labels, 0 * labels], -1)), "or grey, found 400 x 440 of mode RGB"),
    "a bomb": (lambda labels: bomb(), "expected a PNG of label numbers"),
    "text": (lambda labels: b"hello", "expected a PNG of label numbers"),
}


@pytest.mark.parametrize("case", BAD_PARSING)
def test_bad_parsing(case, refused, coarse, wanted, landmarks, tmp_path):
    make, words = BAD_PARSING[case]
    (tmp_path / "labels.png").write_bytes(make(label_map(wanted)))
    out = tmp_path / "out" / "refined.obj"
    said = refused(COMMAND, coarse, landmarks, "--parsing", tmp_path / "labels.png", "--out", out)
    assert words in said and "labels.png" in said and not out.parent.exists()


def test_a_malformed_legend(refused, coarse, wanted, landmarks, tmp_path):
    Image.fromarray(label_map(wanted)).save(tmp_path / "labels.png")
    (tmp_path / "labels.json").write_text('{"eye_left": 4}')
    out = tmp_path / "out" / "refined.obj"
    said = refused(COMMAND, coarse, landmarks, "--parsing", tmp_path / "labels.png", "--out", out)
    assert "labels.json: expected schema 'caricli.parsing/1'" in said and not out.parent.exists()


@pytest.mark.parametrize("suffix", [".obj", ".npz"])
def test_a_face_without_camera(suffix, refused, coarse, landmarks, tmp_path):
    face = read_face(coarse)
    path = (tmp_path / "bare").with_suffix(suffix)
    if suffix == ".obj":
        write_obj(path, face.mesh)
    else:
        write_face(path, replace(face, camera=None))
    said = refused(COMMAND, path, landmarks, "--out", tmp_path / "out" / "refined.obj")
    assert f"{path}: expected a face with the camera of its picture" in said
    assert "caricli reconstruct-from-landmarks" in said and not (tmp_path / "out").exists()


def test_outputs_that_exist_and_wrong_usage(refused, run, coarse, landmarks, refined, tmp_path):
    before = (refined / NAMES[2]).read_bytes()
    assert "--overwrite" in refused(COMMAND, coarse, landmarks, "--out", refined / NAMES[2])
    assert (refined / NAMES[2]).read_bytes() == before
    said = refused(COMMAND, coarse, landmarks, "--out", coarse.with_suffix(".obj"), "--overwrite")
    assert "found one of the inputs" in said
    for wrong in (("--weight", 0), ("--weight", "nan"), ("--laplacian", "other"), ("--subdivide", 9)):
        assert run(COMMAND, coarse, landmarks, "--out", tmp_path / "a.obj", *wrong).exit_code == 2
    assert list(tmp_path.iterdir()) == [landmarks]


def test_pts_from_0_are_a_pixel_away(run, coarse, wanted, tmp_path):
    write_landmarks(tmp_path / "marks.pts", Landmarks(wanted))
    places = []
    for origin in (0, 1):
        out = tmp_path / f"{origin}.obj"
        result = run(COMMAND, coarse, tmp_path / "marks.pts", "--pts-origin", origin, "--weight", 1e4, "--out", out)
        assert result.exit_code == 0, result.output
        places.append(read_face(out.with_suffix(".npz")).landmarks)
    np.testing.assert_allclose(places[0] - places[1], 1, atol=0.05)
