import numpy as np
import pytest

from caricli.errors import InputError, UsageError
from caricli.io.image import write_png
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.store.face_pictures import FaceReader, seen_files, write_seen_landmarks
from caricli.structures import Landmarks
from caricli.structures.detection import DetectedFace, FaceFrame, SeenFace


@pytest.fixture
def points():
    return np.random.default_rng(0).uniform(10, 60, (81, 2))


@pytest.fixture
def files(points, tmp_path):
    """A picture and landmarks of it."""
    write_png(tmp_path / "photo.png", np.full((70, 90, 3), 200, np.uint8))
    write_landmarks(tmp_path / "marks.json", Landmarks(points[:68], (90, 70)))
    return tmp_path / "photo.png", tmp_path / "marks.json"


@pytest.fixture
def reader(points, monkeypatch):
    """A FaceReader that sees a face in every picture."""
    marks = Landmarks(points, (90, 70), np.tile(np.eye(2), (81, 1, 1)), np.ones(81))
    face = DetectedFace(FaceFrame.of(points), 0.6, marks)
    seen = SeenFace(face, np.zeros((70, 90), np.uint8), 2, "its score is 0.60")
    monkeypatch.setattr(FaceReader, "see", lambda self, pixels: seen)
    return FaceReader()


def test_landmarks_that_are_given_need_no_detector(files):
    photo, marks = files
    picture = FaceReader(marks.with_name("no-detector")).read(marks, 68, photo)
    assert picture.seen is None and picture.pixels.shape == (70, 90, 3)
    assert picture.figures() == {} and picture.note(marks) is None
    assert seen_files(marks, marks.with_name("face.obj")) == []
    write_seen_landmarks(marks.with_name("face.obj"), picture)
    assert len([*marks.parent.iterdir()]) == 2


def test_of_found_landmarks_in_a_file_those_beyond_the_mesh_are_left_out(files, points):
    photo, marks = files
    for spreads, left in ((np.tile(np.eye(2), (81, 1, 1)), 68), (None, 81)):
        write_landmarks(marks, Landmarks(points, (90, 70), spreads))
        assert len(FaceReader().read(marks, 68, photo).landmarks.points) == left


def test_a_picture_alone_is_seen(files, reader, points):
    photo, _ = files
    picture = reader.read(photo, 81)
    np.testing.assert_array_equal(picture.landmarks.points, points)
    assert picture.note("a") == "a: took the largest of 3 faces; the face is doubtful: its score is 0.60"
    assert picture.figures()["detected"] | {"spread": 0} == {
        "score": 0.6, "spread": 0, "known": 81, "other_faces": 2, "doubt": "its score is 0.60"
    }  # fmt: skip
    short = reader.read(photo, 68)
    assert len(short.landmarks.points) == len(short.landmarks.spreads) == len(short.landmarks.visibility) == 68
    out = photo.with_name("face.obj")
    beside = photo.with_name("face-landmarks.json")
    assert seen_files(photo, out) == [beside]
    write_seen_landmarks(out, short)
    np.testing.assert_array_equal(read_landmarks(beside).points, points)


def test_a_picture_is_no_picture_of_a_picture(files, reader):
    photo, _ = files
    with pytest.raises(UsageError, match="photo.png is a picture itself"):
        reader.read(photo, 81, photo)


def test_failures_name_their_file(files, monkeypatch):
    def see(self, pixels):
        raise InputError("expected a face, found none")

    monkeypatch.setattr(FaceReader, "see", see)
    with pytest.raises(InputError, match=r"photo\.png: expected a face, found none"):
        FaceReader().read(files[0], 81)
    with pytest.raises(InputError, match="gone.png: expected a picture or a landmark file, found no such file"):
        FaceReader().read(files[0].with_name("gone.png"), 81)
    with pytest.raises(InputError, match=": expected a picture or a landmark file, found a folder"):
        FaceReader().read(files[0].parent, 81)
