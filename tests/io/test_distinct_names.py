from pathlib import Path

import pytest

from caricli.io.distinct_names import distinct_names


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        (["a/face.npz", "b/other.obj"], ["face", "other"]),
        (["a/face.npz", "b/face.npz"], ["a", "b"]),
        (["a/b/face.npz", "a/face.npz"], ["b", "face"]),
        (["x/face.npz", "x/face.obj"], ["face", "face"]),
        (["x/..png", "x/...png"], ["..png", "...png"]),
        (["a/..png", "b/..png", "c/x.png"], ["a-..png", "b-..png", "c-x"]),
        (["x/face.npz", "x/../x/face.npz"], ["face", "face"]),
        (["x/../a/face.npz", "../face.npz", "b/face.npz"], ["work-a", "face", "work-b"]),
    ],
)
def test_files_are_told_apart_by_their_folders(paths, names, tmp_path, monkeypatch):
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    assert distinct_names([Path(path) for path in paths], "-") == names
