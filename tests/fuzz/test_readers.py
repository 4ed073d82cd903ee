"""The fuzzer for a while, and that it knows every reader."""

import importlib.util
import inspect
import pkgutil
import random
from importlib import import_module

import pytest

import caricli.data
import caricli.io
from caricli.errors import CaricliError
from tests.fuzz import readers as module
from tests.fuzz.__main__ import fuzz
from tests.fuzz.judge import judged
from tests.fuzz.readers import READERS

# Readers that others are made of, and those of folders and of files that come with caricli.
PARTS = {"read_array", "read_bytes", "read_container", "read_start", "read_text", "read_yaml"}
PARTS |= {"read_manifest", "read_named"}
BEHIND_OTHERS = {
    "read_gltf_mesh",
    "read_level",
    "read_pictures",
    "read_obj",
    "read_painted_obj",
    "read_ply",
    "read_stl",
}


def test_every_reader_is_fuzzed():
    names = set()
    for room in (caricli.io, caricli.data):
        for entry in pkgutil.walk_packages(room.__path__, f"{room.__name__}."):
            members = vars(import_module(entry.name))
            names |= {name for name, value in members.items() if name.startswith("read_") and inspect.isfunction(value)}
    text = inspect.getsource(module)
    assert {name for name in names - PARTS - BEHIND_OTHERS if f"{name}" not in text} == set()


@pytest.mark.parametrize("name", READERS)
def test_good_files_are_read(tmp_path, name):
    for content in READERS[name].good_files(tmp_path):
        (tmp_path / name).write_bytes(content)
        try:
            READERS[name].read(tmp_path / name)
        except CaricliError as error:
            # Some formats are told by the names of their files, and this one has none.
            assert name == "any.bin", error


@pytest.mark.parametrize("name", [name for name, reader in READERS.items() if reader.mutate])
def test_what_is_inside_is_reached(tmp_path, name):
    reader = READERS[name]
    refusals = set()
    for content in reader.good_files(tmp_path):
        for seed in range(20):
            changed = reader.mutate(content, random.Random(seed))
            (tmp_path / name).write_bytes(changed)
            assert judged(reader.read, tmp_path / name) is None
            try:
                reader.read(tmp_path / name)
            except CaricliError as error:
                refusals.add(str(error))
    # Whatever is wrong with it, a state is damaged; names are two of a face's many arrays; and any value is JSON.
    assert len(refusals) > 3 or name in ("state.pt", "names.npz", "value.json")


@pytest.mark.parametrize("byte", [b"\0", b"\n", b" ", b".", b"a", b"0"])
@pytest.mark.parametrize("name", READERS)
def test_long_runs_are_read_soon(tmp_path, name, byte):
    (tmp_path / name).write_bytes(byte * 65536)
    assert judged(READERS[name].read, tmp_path / name) is None


@pytest.mark.skipif(importlib.util.find_spec("atheris") is None, reason="atheris is not made for this system")
@pytest.mark.parametrize("seconds", [10, pytest.param(40, marks=pytest.mark.slow)])
def test_fuzzing_finds_nothing(tmp_path, seconds):
    assert fuzz(tmp_path, seconds) == []
