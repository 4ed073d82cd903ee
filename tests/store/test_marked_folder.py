import json

import numpy as np
import pytest
from PIL import Image

from caricli.errors import InputError, OutputError
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.store.marked_folder import MarkedFolder
from caricli.structures import Landmarks

POINTS = np.random.default_rng(0).uniform(5, 55, (68, 2))


@pytest.fixture
def folder(tmp_path):
    for name in ("b.png", "a.jpg", "c.webp"):
        Image.new("RGB", (64, 64)).save(tmp_path / name)
    (tmp_path / "notes.md").write_text("no picture")
    return tmp_path


def test_pictures_come_by_their_names_and_one_picture_alone(folder):
    assert [each.name for each in MarkedFolder.of(folder).pictures] == ["a.jpg", "b.png", "c.webp"]
    alone = MarkedFolder.of(folder / "b.png")
    assert alone.pictures == (folder / "b.png",) and alone.others(folder / "b.png") == []
    (folder / "empty").mkdir()
    with pytest.raises(InputError, match="expected pictures .*, found none"):
        MarkedFolder.of(folder / "empty")


def test_two_pictures_of_one_name_are_refused_because_they_would_share_their_landmarks(folder):
    Image.new("RGB", (64, 64)).save(folder / "a.png")
    with pytest.raises(InputError, match=r"expected pictures whose names differ .*, found a\.jpg and a\.png"):
        MarkedFolder.of(folder)
    assert MarkedFolder.of(folder / "a.png").pictures == (folder / "a.png",)


def test_what_is_done_is_told_by_the_files(folder):
    a, b, c = (folder / name for name in ("a.jpg", "b.png", "c.webp"))
    marked = MarkedFolder.of(folder)
    assert marked.done == 0 and marked.first() == a and marked.read(a) is None
    assert marked.write(b, Landmarks(POINTS, (64, 64))) == folder / "b.json"
    assert (
        marked.candidates(a) == [a, c, b]
        and marked.done == 1
        and marked.first() == a
        and marked.left(a) == [c]
        and marked.left(c) == [a]
    )
    assert np.array_equal(marked.read(b).points, POINTS)
    again = MarkedFolder.of(folder)
    again.write(a, Landmarks(POINTS))
    assert again.first() == c and again.left(c) == [] and again.candidates(c) == [c, a, b]
    again.write(c, Landmarks(POINTS))
    assert again.left(c) == [] and again.first() == a and again.done == 3
    assert again.others(c) == [a, b] and again.others(a, -1) == [c, b]


@pytest.mark.parametrize("suffix", [".json", ".pts", ".txt", ".npy"])
def test_a_file_keeps_its_format(folder, suffix):
    file = folder / f"a{suffix}"
    write_landmarks(file, Landmarks(POINTS))
    marked = MarkedFolder.of(folder)
    off = POINTS.copy()
    off[3] = np.nan
    assert marked.write(folder / "a.jpg", Landmarks(off)) == file
    assert np.allclose(read_landmarks(file).points, off, equal_nan=True)
    assert sorted(each.suffix for each in folder.glob("a.*")) == sorted([".jpg", suffix])


def test_what_holds_something_else_is_not_replaced(folder):
    (folder / "a.json").write_text(json.dumps({"schema": "mine"}))
    marked = MarkedFolder.of(folder)
    with pytest.raises(OutputError, match="mine.*it is not replaced"):
        marked.write(folder / "a.jpg", Landmarks(POINTS))
    with pytest.raises(InputError):
        marked.read(folder / "a.jpg")
    assert json.loads((folder / "a.json").read_text()) == {"schema": "mine"}


def test_landmarks_of_another_picture_are_refused(folder):
    write_landmarks(folder / "a.json", Landmarks(POINTS + 900, (1000, 1000)))
    with pytest.raises(InputError, match="expected landmarks of the 64 x 64 picture"):
        MarkedFolder.of(folder).read(folder / "a.jpg")


def test_landmarks_of_another_picture_are_not_replaced(folder):
    others = Landmarks(POINTS + 900, (1000, 1000))
    write_landmarks(folder / "a.json", others)
    with pytest.raises(OutputError, match="expected landmarks of the 64 x 64 picture .*; it is not replaced"):
        MarkedFolder.of(folder).write(folder / "a.jpg", Landmarks(POINTS, (64, 64)))
    assert np.array_equal(read_landmarks(folder / "a.json").points, others.points)


def test_files_of_other_things_are_no_landmarks(folder):
    a, b, c = (folder / name for name in ("a.jpg", "b.png", "c.webp"))
    (folder / "a.txt").write_text("a photo of a man\n")
    (folder / "b.json").write_text('{"command": "texture"}')
    marked = MarkedFolder.of(folder)
    assert marked.done == 0 and marked.first() == a and marked.left(c) == [a, b]
    assert marked.write(a, Landmarks(POINTS, (64, 64))) == folder / "a.json" and marked.done == 1
    assert (folder / "a.txt").read_text() == "a photo of a man\n"
    with pytest.raises(OutputError, match="b.json: .*; it is not replaced"):
        marked.write(b, Landmarks(POINTS, (64, 64)))
