import os
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from caricli.errors import NumericsError
from caricli.io import kept
from caricli.io.kept import kept_arrays


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(kept, "QUICK", -1.0)
    return tmp_path / "caricli" / "kept"


class Made:
    """Arrays that count how often they are made."""

    def __init__(self):
        self.times = 0

    def __call__(self):
        self.times += 1
        return {"half": np.arange(6).reshape(2, 3) / 2}


def test_what_was_made_is_not_made_again():
    make = Made()
    first = kept_arrays("thing", (np.arange(3), "a", 0.5), make)
    again = kept_arrays("thing", (np.arange(3), "a", 0.5), make)
    assert make.times == 1
    assert [*again] == [*first] and again["half"].dtype == first["half"].dtype
    np.testing.assert_array_equal(again["half"], first["half"])


@pytest.mark.parametrize("other", [(np.arange(4), "a"), (np.arange(3) / 1, "a"), (np.arange(3), "b"), (np.arange(3),)])
def test_another_thing_is_made(other):
    make = Made()
    kept_arrays("thing", (np.arange(3), "a"), make)
    kept_arrays("thing", other, make)
    assert make.times == 2


def test_what_is_kept_does_not_hang_on_how_many_threads_made_it():
    usual = [library["num_threads"] for library in threadpool_info()]
    makers = []

    def make():
        makers.extend(library["num_threads"] for library in threadpool_info())
        return {}

    kept_arrays("thing", (), make)
    assert makers and {*makers} == {1}
    assert [library["num_threads"] for library in threadpool_info()] == usual


def test_two_that_are_made_at_once_wait_for_each_other():
    usual = [library["num_threads"] for library in threadpool_info()]
    inside = []
    most = []

    def make():
        inside.append(1)
        time.sleep(0.05)
        most.append(len(inside))
        inside.pop()
        return {}

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda name: kept_arrays(name, (), make), ("one", "other")))
    assert most == [1, 1] and [library["num_threads"] for library in threadpool_info()] == usual


def test_a_cache_that_can_only_be_read_is_read(monkeypatch):
    make = Made()
    kept_arrays("thing", (), make)

    def refused(_path):
        raise PermissionError

    monkeypatch.setattr(os, "utime", refused)
    kept_arrays("thing", (), make)
    assert make.times == 1


def test_what_another_program_made_does_not_count(monkeypatch):
    make = Made()
    kept_arrays("thing", (), make)
    monkeypatch.setattr(kept, "_program", lambda: "another")
    kept_arrays("thing", (), make)
    assert make.times == 2


def test_the_program_is_every_file_of_it(tmp_path):
    (tmp_path / "a.py").write_text("a")
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "b.py").write_text("b")
    (tmp_path / "a.txt").write_text("a")
    assert sorted(path.removeprefix(str(tmp_path)) for path, _ in kept._sources(tmp_path)) == ["/a.py", "/deep/b.py"]


@pytest.mark.parametrize(
    "damage", [lambda data: data[:-30], lambda data: b"", lambda data: data[:200] + b"x" + data[201:]]
)
def test_damage_is_mended(folder, damage):
    make = Made()
    kept_arrays("thing", (), make)
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    np.testing.assert_array_equal(kept_arrays("thing", (), make)["half"], make()["half"])
    assert make.times == 3 and file.read_bytes() == whole


def test_what_was_not_asked_for_goes_first(folder, monkeypatch):
    for number in range(3):
        kept_arrays("thing", (float(number),), Made())
    for file, second in zip(
        sorted(folder.iterdir(), key=lambda file: file.stat().st_mtime_ns), (10, 20, 30), strict=True
    ):
        os.utime(file, (second, second))
    size = file.stat().st_size
    kept_arrays("thing", (0.0,), Made())
    monkeypatch.setattr(kept, "MOST", 3 * size)
    kept_arrays("other", (), Made())
    assert len([*folder.iterdir()]) == 3
    times = {}
    for number in range(3):
        times[number] = Made()
        kept_arrays("thing", (float(number),), times[number])
    assert times[0].times == 0 and times[1].times == 1


def test_what_is_made_quickly_is_not_kept(folder, monkeypatch):
    monkeypatch.setattr(kept, "QUICK", 3600.0)
    kept_arrays("thing", (), Made())
    assert not folder.exists()


def test_a_folder_that_cannot_be_written_only_costs_time(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    make = Made()
    for _ in range(2):
        np.testing.assert_array_equal(kept_arrays("thing", (), make)["half"][0], [0, 0.5, 1])
    assert make.times == 2


def test_failures_are_those_of_what_makes_it(folder):
    def fail():
        raise NumericsError("singular")

    with pytest.raises(NumericsError, match="singular"):
        kept_arrays("thing", (), fail)
    assert not folder.exists()
