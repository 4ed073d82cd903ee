"""Commands that take landmarks find them where they are given a picture."""

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.face import read_face
from caricli.io.image import write_png
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.io.strict_json import read_json
from caricli.store.face_pictures import FaceReader
from caricli.structures import Landmarks
from caricli.structures.detection import DetectedFace, FaceFrame, SeenFace

COMMAND = "reconstruct-from-landmarks"


@pytest.fixture
def drawings(points, tmp_path, monkeypatch):
    """A picture with a face that is not sure, and one without: a detector that sees what their first pixel says."""
    folder = tmp_path / "drawings"
    folder.mkdir()
    for name, grey in (("face", 200), ("wall", 0)):
        write_png(folder / f"{name}.png", np.full((400, 400, 3), grey, np.uint8))
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    spreads = np.tile((0.01 * diagonal) ** 2 * np.eye(2), (81, 1, 1))
    marks = np.array(points)
    marks[72] = np.nan
    spreads[72] = np.nan
    face = DetectedFace(FaceFrame.of(points), 0.5, Landmarks(marks, (400, 400), spreads, np.ones(81)))

    def see(self, pixels):
        if not pixels.any():
            raise InputError("expected a face, found none")
        return SeenFace(face, np.zeros((400, 400), np.uint8), 0, "its score is 0.50")

    monkeypatch.setattr(FaceReader, "see", see)
    return folder


def test_faces_are_fitted_to_where_the_heads_own_landmarks_were_seen(run, points, tmp_path):
    slides = np.random.default_rng(0).normal(size=points.shape)
    write_landmarks(tmp_path / "slid.json", Landmarks(points - slides, (400, 400), slides=slides))
    write_landmarks(tmp_path / "seen.json", Landmarks(points - slides + slides, (400, 400)))
    for name in ("slid", "seen"):
        result = run(COMMAND, tmp_path / f"{name}.json", "--out", tmp_path / f"{name}-face.obj")
        assert result.exit_code == 0, result.output
    assert (tmp_path / "slid-face.npz").read_bytes() == (tmp_path / "seen-face.npz").read_bytes()


def test_what_was_found_is_written_beside_the_result_and_can_be_corrected(run, drawings, points, tmp_path):
    out = tmp_path / "out" / "face.obj"
    result = run(COMMAND, drawings / "face.png", "--no-picture", "--out", out)
    assert result.exit_code == 0, result.output
    assert result.stderr == f"{drawings / 'face.png'}: the face is doubtful: its score is 0.50\n"
    names = sorted(path.name for path in out.parent.iterdir())
    assert names == ["face-landmarks.json", "face.json", "face.npz", "face.obj"]
    report = read_json(out.with_suffix(".json"))
    assert report["detected"]["doubt"] == "its score is 0.50" and report["detected"]["known"] == 80
    beside = read_landmarks(out.with_name("face-landmarks.json"))
    assert np.isnan(beside.points[72]).all() and beside.spreads is not None
    # The file in the picture's place gives the same face.
    again = tmp_path / "again.obj"
    picture = ("--image", drawings / "face.png", "--no-picture")
    assert run(COMMAND, out.with_name("face-landmarks.json"), *picture, "--out", again).exit_code == 0
    first, second = (read_face(path.with_suffix(".npz")) for path in (out, again))
    np.testing.assert_array_equal(first.vertices, second.vertices)
    known = np.isfinite(beside.points).all(axis=1)
    assert np.linalg.norm(first.landmarks - points, axis=1)[known].mean() < 0.02 * np.ptp(points[:, 1])
    # Refining goes the same way.
    refined = tmp_path / "refined.obj"
    result = run("refine", out.with_suffix(".npz"), drawings / "face.png", "--no-picture", "--out", refined)
    assert result.exit_code == 0, result.output
    assert refined.with_name("refined-landmarks.json").is_file() and "doubtful" in result.stderr


def test_a_picture_without_a_face_is_one_line_and_stops_no_other(run, refused, drawings, tmp_path):
    wall = drawings / "wall.png"
    assert (
        refused(COMMAND, wall, "--out", tmp_path / "a.obj") == f"caricli: error: {wall}: expected a face, found none\n"
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drawings"]
    result = run(COMMAND, wall, drawings / "face.png", "--no-picture", "--out-dir", tmp_path / "faces")
    assert result.exit_code == 1 and "wall.png: expected a face" in result.stderr and "1 of 2 failed" in result.stderr
    assert (tmp_path / "faces" / "face.obj").is_file() and not (tmp_path / "faces" / "wall.obj").exists()


def test_one_picture_has_no_other(refused, drawings, tmp_path):
    pair = (drawings / "face.png", "--image", drawings / "wall.png")
    assert "is a picture itself" in refused(COMMAND, *pair, "--out", tmp_path / "a.obj", code=2)


@pytest.mark.usefixtures("quick_pictures")
def test_expressions_and_drivers_begin_at_a_picture(run, drawings, tmp_path):
    moods = tmp_path / "moods.yaml"
    moods.write_text("neutral: {}\nopen: {jawOpen: 0.8}\n")
    rig = tmp_path / "rig" / "b.npz"
    result = run("blendshapes", drawings / "face.png", "--expressions", moods, "--no-picture", "--out", rig)
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in rig.parent.iterdir()) == ["b-landmarks.json", "b.glb", "b.json", "b.npz"]
    assert read_json(rig.with_suffix(".json"))["detected"]["doubt"] == "its score is 0.50"
    # The landmarks that were written drive as the picture does.
    vertices = {}
    for name, driver in (("picture", drawings / "face.png"), ("marks", rig.with_name("b-landmarks.json"))):
        out = tmp_path / name / "face.obj"
        result = run("retarget", rig, driver, "--no-picture", "--out", out)
        assert result.exit_code == 0, result.output
        vertices[name] = read_face(out.with_suffix(".npz")).vertices
    assert (tmp_path / "picture" / "face-landmarks.json").is_file()
    assert not (tmp_path / "marks" / "face-landmarks.json").exists()
    assert read_json(tmp_path / "picture" / "face.json")["detected"]["doubt"] == "its score is 0.50"
    np.testing.assert_array_equal(vertices["picture"], vertices["marks"])
