import hashlib
import os

import pytest

from caricli import __version__
from caricli.errors import InputError
from caricli.io.provenance import made_of, provenance, sha256_file


def test_hashes(tmp_path):
    (tmp_path / "a").write_bytes(b"abc" * 100_000)
    assert sha256_file(tmp_path / "a") == hashlib.sha256(b"abc" * 100_000).hexdigest()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("missing", "found no such file"),
        ("folder", "found a folder"),
        ("pipe", "found something that is not a regular file"),
        ("a\0b", "cannot be read"),
    ],
)
def test_unreadable(tmp_path, name, words):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match=words):
        sha256_file(f"{tmp_path}/{name}")


def test_provenance(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"abc")
    expected = {
        "command": "train pca",
        "version": __version__,
        "inputs": {str(path): hashlib.sha256(b"abc").hexdigest()},
        "seed": 0,
        "components": 128,
    }
    assert provenance("train pca", [path, None], seed=0, components=128) == expected
    own = tmp_path / ".caricli-mine"
    own.mkdir()
    (own / "a").write_bytes(b"abc")
    assert [*provenance("inspect", [own / "a"])["inputs"]] == [str(own / "a")]
    assert provenance("render", []) == {"command": "render", "version": __version__, "inputs": {}}


def test_what_a_run_read_is_told_by_its_bytes_wherever_it_lies(tmp_path):
    for name, content in {"a": b"abc", "b": b"abc", "c": b"abd"}.items():
        (tmp_path / name).write_bytes(content)
    recipe = provenance("train it", [tmp_path / "a"])
    assert [made_of(recipe, tmp_path / name) for name in "abc"] == [True, True, False]
    assert not any(made_of(other, tmp_path / "a") for other in (None, "text", {}, {"inputs": None}))
