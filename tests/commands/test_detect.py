import json
import shutil

import numpy as np
import pytest
import torch

from caricli.io.checkpoint import write_checkpoint
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import read_landmarks
from caricli.io.parsing import read_parsing
from caricli.models.detector.config import DetectorSize
from caricli.models.detector.model import detector_to_checkpoint
from caricli.models.detector.networks import DetectorNetwork, detector_of
from caricli.structures.detection import DetectedFace, Detection, FaceFrame
from caricli.structures.landmarks import Landmarks
from caricli.structures.parsing import Region
from tests.drawn_pictures import drawn_picture, mean_shape


@pytest.fixture(scope="module")
def detector(tmp_path_factory):
    """The file of a Detector that has learnt nothing."""
    path = tmp_path_factory.mktemp("detector") / "model.safetensors"
    network = DetectorNetwork(DetectorSize(8, 16, 1), 81, len(Region), torch.Generator().manual_seed(0))
    write_checkpoint(path, *detector_to_checkpoint(detector_of(network, 64)))
    return path


@pytest.fixture
def pictures(head_template, tmp_path, monkeypatch):
    """Two drawings, of two faces and of none, and a detector that sees what is in them."""
    shape = mean_shape(head_template)
    truths = {}
    for name, faces in (("pair", 2), ("wall", 0)):
        picture = drawn_picture(shape, np.random.default_rng(3), faces)
        write_png(tmp_path / f"{name}.png", picture.pixels)
        truths[picture.pixels.tobytes()] = picture

    def detect(pixels, detector, settings):
        truth = truths[pixels.tobytes()]
        spreads = np.tile(2 * np.eye(2), (81, 1, 1))
        faces = []
        for points in truth.landmarks:
            known = np.where((np.arange(81) == 5)[:, None], np.nan, points)
            own = Landmarks(known, (160, 160), np.where(np.isnan(known)[..., None], np.nan, spreads), np.full(81, 0.75))
            faces.append(DetectedFace(FaceFrame.of(points), 0.9, own))
        faces = [face for face in faces if face.score >= settings.sure]
        return Detection(sorted(faces, key=lambda face: -face.frame.side), truth.regions)

    monkeypatch.setattr("caricli.methods.detect.detect_faces.detect_faces", detect)
    return tmp_path, truths


def test_landmarks_regions_and_an_overlay_are_written(run, detector, pictures, tmp_path):
    folder, truths = pictures
    out = tmp_path / "marks"
    result = run("detect", folder / "pair.png", "--detector", detector, "--out-dir", out)
    assert result.exit_code == 0, result.output
    assert "the largest of 2, score 0.90" in result.stdout
    assert sorted(path.name for path in out.iterdir()) == [
        "pair-overlay.png", "pair-regions.json", "pair-regions.png", "pair.json"
    ]  # fmt: skip
    truth = next(iter(truths.values()))
    frames = [FaceFrame.of(points) for points in truth.landmarks]
    largest = truth.landmarks[int(np.argmax([frame.side for frame in frames]))]
    marks = read_landmarks(out / "pair.json")
    np.testing.assert_allclose(np.delete(marks.points, 5, 0), np.delete(largest, 5, 0))
    assert not marks.known[5] and marks.image_size == (160, 160)
    np.testing.assert_allclose(marks.spreads[0], 2 * np.eye(2))
    assert json.loads((out / "pair.json").read_text())["spreads"][5] is None
    labels, legend = read_parsing(out / "pair-regions.png")
    np.testing.assert_array_equal(labels, truth.regions)
    assert legend["skin"] == 1 and len(legend) == 16
    about = json.loads((out / "pair-regions.json").read_text())
    assert [face["known"] for face in about["faces"]] == [80, 80] and about["command"] == "detect"
    assert read_image(out / "pair-overlay.png").shape == (160, 320, 3)


def test_all_faces_are_written_where_they_are_asked_for(run, detector, pictures, tmp_path):
    folder, _ = pictures
    result = run("detect", folder / "pair.png", "--all", "--detector", detector, "--out-dir", tmp_path / "marks")
    assert result.exit_code == 0 and "2 faces" in result.stdout
    sides = [np.ptp(read_landmarks(tmp_path / "marks" / name).points[:17, 0]) for name in ("pair.json", "pair-2.json")]
    assert len(set(sides)) == 2


def test_a_face_of_an_earlier_picture_is_named(run, detector, pictures, tmp_path):
    folder, _ = pictures
    marks = tmp_path / "marks"
    marks.mkdir()
    words = ("detect", folder / "pair.png", "--all", "--detector", detector, "--out-dir", marks, "--overwrite")
    assert "was there before" not in run(*words).stderr
    shutil.copy(marks / "pair.json", marks / "pair-3.json")
    told = run(*words)
    assert told.exit_code == 0 and "pair-3.json: was there before, and is no face of" in told.stderr


def test_how_sure_a_face_must_be_is_as_it_is_said(run, refused, detector, pictures, tmp_path):
    words = ("detect", pictures[0] / "pair.png", "--detector", detector, "--out-dir")
    assert "expected a face, found none" in refused(*words, tmp_path / "none", "--score", 0.95)
    assert run(*words, tmp_path / "sure", "--score", 0.85).exit_code == 0
    assert json.loads((tmp_path / "sure" / "pair-regions.json").read_text())["score"] == 0.85


def test_second_faces_do_not_replace_another_picture_s(run, detector, pictures, tmp_path):
    folder, _ = pictures
    shutil.copy(folder / "pair.png", folder / "pair-2.png")
    paths = (folder / "pair.png", folder / "pair-2.png")
    result = run("detect", *paths, "--all", "--detector", detector, "--out-dir", tmp_path / "marks", "--overwrite")
    assert result.exit_code == 1 and "1 of 2 failed" in result.stderr
    assert f"pair-2.json: expected an output of its own, found what was written for {paths[0]}\n" in result.stderr
    assert {path.name for path in (tmp_path / "marks").glob("*.json")} == {
        "pair.json", "pair-2.json", "pair-regions.json"
    }  # fmt: skip


def test_a_picture_that_is_still_to_be_read_is_not_replaced(run, detector, pictures, tmp_path):
    folder, _ = pictures
    overlay = folder / "pair-overlay.png"
    shutil.copy(folder / "pair.png", overlay)
    paths = (folder / "pair.png", overlay)
    result = run("detect", *paths, "--detector", detector, "--out-dir", folder, "--overwrite")
    assert result.exit_code == 1 and "1 of 2 failed" in result.stderr
    assert "pair-overlay.png: expected an output, found one of the inputs" in result.stderr
    assert overlay.read_bytes() == paths[0].read_bytes()
    assert (folder / "pair-overlay.json").exists() and not (folder / "pair.json").exists()


def test_a_picture_without_a_face_fails_alone(run, refused, detector, pictures, tmp_path):
    folder, _ = pictures
    told = refused("detect", folder / "wall.png", "--detector", detector, "--out-dir", tmp_path / "one")
    assert "wall.png: expected a face, found none" in told and not (tmp_path / "one").exists()
    result = run(
        "detect", folder / "wall.png", folder / "pair.png", "--detector", detector, "--out-dir", tmp_path / "two"
    )
    assert result.exit_code == 1 and "1 of 2 failed" in result.stderr
    assert (tmp_path / "two" / "pair.json").is_file()


def test_a_detector_that_has_learnt_nothing_finds_nothing(refused, detector, tmp_path):
    write_png(tmp_path / "noise.png", np.random.default_rng(0).integers(0, 256, (90, 70, 3), np.uint8))
    assert "found none" in refused(
        "detect", tmp_path / "noise.png", "--detector", detector, "--out-dir", tmp_path / "o"
    )


def test_it_can_be_inspected(run, detector):
    result = run("inspect", detector)
    assert result.exit_code == 0 and "windows of 64 pixels" in result.stdout


def test_what_is_no_detector_is_refused(refused, tmp_path):
    write_png(tmp_path / "a.png", np.zeros((8, 8, 3), np.uint8))
    told = refused("detect", tmp_path / "a.png", "--detector", tmp_path / "a.png", "--out-dir", tmp_path / "o")
    assert "expected a .safetensors model" in told
    assert refused("detect", tmp_path / "a.png", code=2)


def test_outputs_that_exist_are_refused_before_faces_are_looked_for(refused, detector, pictures, monkeypatch, tmp_path):
    folder, _ = pictures
    monkeypatch.setattr("caricli.methods.detect.detect_faces.detect_faces", pytest.fail)
    (tmp_path / "marks-overlay.png").write_bytes(b"mine")
    said = refused("detect", folder / "pair.png", "--detector", detector, "--out", tmp_path / "marks.json")
    assert "marks-overlay.png exists; give --overwrite to replace it" in said
