import json
import sys

import numpy as np
import pytest

from caricli.io.image import read_image, write_png
from caricli.io.landmarks import read_landmarks
from caricli.structures.detection import DetectedFace, FaceFrame, SeenFace
from caricli.structures.landmarks import Landmarks

FAILS = f"{sys.executable} -c 'import sys; sys.exit(5)' {{input}} {{output}}"


@pytest.fixture
def portrait(tmp_path):
    rows, columns = np.mgrid[:400, :400]
    image = np.dstack([columns, rows, (columns // 8 + rows // 8) % 2 * 200]) * 200 // 400
    write_png(tmp_path / "photo.png", image.astype(np.uint8))
    return tmp_path / "photo.png"


def test_picture_landmarks_report_and_sheet_are_written_and_always_the_same(run, portrait, marks, tmp_path):
    for name in ("a", "b"):
        result = run("stylise", portrait, "--landmarks", marks, "--style", "ink", "--out", tmp_path / name / "p.png")
        assert result.exit_code == 0, result.output
    assert "p.png: ink, landmarks moved by " in result.stdout
    names = ["p-report.json", "p-sheet.png", "p.json", "p.png"]
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == names
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert read_image(tmp_path / "a" / "p.png").shape == (400, 400, 3)
    moved = read_landmarks(tmp_path / "a" / "p.json")
    given = read_landmarks(marks)
    assert moved.image_size == (400, 400) and moved.points.shape == (68, 2)
    report = json.loads((tmp_path / "a" / "p-report.json").read_text())
    share = 100 * np.linalg.norm(moved.points - given.points, axis=1).mean() / given.diagonal
    assert report["moved"] == pytest.approx(share) and share > 0.5
    assert (report["style"], report["shape"], report["strength"], report["seed"]) == ("ink", "map", 1.0, 0)


def test_landmarks_are_found_where_none_are_given(run, portrait, points, monkeypatch, tmp_path):
    marks = Landmarks(points, (400, 400), np.tile(np.eye(2), (81, 1, 1)), np.ones(81))
    face = DetectedFace(FaceFrame.of(points), 0.5, marks)
    monkeypatch.setattr("caricli.store.detector.load_detector", lambda path: None)
    monkeypatch.setattr(
        "caricli.methods.detect.see_face.see_face", lambda *_: SeenFace(face, np.zeros(()), 0, "its score is 0.50")
    )
    write_png(tmp_path / "other.png", read_image(portrait))
    typed = ("stylise", portrait, tmp_path / "other.png", "--shape", "none", "--style", "flat", "--no-picture")
    result = run(*typed, "--out-dir", tmp_path / "many")
    assert result.exit_code == 0, result.output
    assert "photo.png: the face is doubtful: its score is 0.50" in result.stderr
    files = sorted(path.name for path in (tmp_path / "many").iterdir())
    assert files == [f"{name}{end}" for name in ("other", "photo") for end in ("-report.json", ".json", ".png")]
    np.testing.assert_array_equal(read_landmarks(tmp_path / "many" / "photo.json").points, points)


def test_a_generator_that_fails_leaves_nothing(refused, portrait, marks, tmp_path):
    typed = ("stylise", portrait, "--landmarks", marks, "--shape", "none", "--generator", FAILS)
    told = refused(*typed, "--out", tmp_path / "out" / "p.png")
    assert "photo.png: the generator" in told and "expected exit 0, found 5" in told
    assert not (tmp_path / "out").exists()


def test_wrong_usage(refused, portrait, marks, tmp_path):
    out = ("--out-dir", tmp_path / "out")
    assert "--landmarks" in refused("stylise", portrait, portrait, "--landmarks", marks, *out, code=2)
    assert "either --style or --gen" in refused("stylise", portrait, "--style", "ink", "--generator", "x", *out, code=2)
    assert "expected a TorchScript file" in refused("stylise", portrait, "--generator", "x", *out, code=2)
    assert "ends in .png" in refused("stylise", portrait, "--out", tmp_path / "p.jpg", code=2)
    assert "--strength" in refused("stylise", portrait, "--strength", "4", *out, code=2)
    for painted in (("--style", "none"), ("--generator", "x {input} {output}")):
        assert "--seed is for what" in refused("stylise", portrait, *painted, "--seed", "1", *out, code=2)


def test_landmarks_of_another_picture_are_refused(refused, portrait, tmp_path):
    told = refused("stylise", portrait, "--landmarks", portrait, "--shape", "none", "--out", tmp_path / "p.png")
    assert "photo.png: expected a landmark file, found a PNG image" in told
    write_png(tmp_path / "small.png", np.zeros((40, 40, 3), np.uint8))
    (tmp_path / "marks.txt").write_text("\n".join(f"{300 + k} {300 + k % 9}" for k in range(68)))
    told = refused(
        "stylise", tmp_path / "small.png", "--landmarks", tmp_path / "marks.txt", "--out", tmp_path / "p.png"
    )
    assert "marks.txt: " in told and "expected the landmarks of a face in the 40 x 40 image" in told
