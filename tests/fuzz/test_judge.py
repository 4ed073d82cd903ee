import ctypes
import re
import sys
import warnings

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.files import read_bytes
from tests.fuzz import judge
from tests.fuzz.judge import judged


def fail(path):
    raise KeyError(path.name)


def speak(path):
    print("ink", file=sys.stderr)


def murmur(path):
    ctypes.CDLL(None).dprintf(2, b"libtiff: odd directory\n")


def warn(path):
    for _ in range(2):
        warnings.warn("overflow", RuntimeWarning, stacklevel=1)


def hoard(path):
    np.empty(2 * judge.MAX_BYTES, np.uint8)


def ramble(path):
    raise InputError("a\nb")


def dawdle(path):
    for _ in range(10**6):
        pass


def refuse(path):
    raise InputError(f"{path.name}: expected a face, found none")


@pytest.mark.parametrize(
    ("read", "words"),
    [
        (fail, "KeyError in "),
        (lambda path: read_bytes(path, None, "a file"), "TypeError in files.py:read_bytes"),
        (speak, "wrote to stderr: ink"),
        (murmur, "wrote to stderr: libtiff"),
        (warn, "warned: RuntimeWarning: overflow"),
        (hoard, "MemoryError in "),
        (ramble, "a message of several lines"),
    ],
)
def test_faults_are_seen(tmp_path, capfd, read, words):
    (tmp_path / "a").write_bytes(b"x")
    # What pytest puts in the place of stderr does not write where stderr does.
    with capfd.disabled():
        problems = [judged(read, tmp_path / "a") for _ in range(2)]
    for problem in problems:
        assert problem is not None and re.match(words, problem), problem
    assert capfd.readouterr() == ("", "")


def test_time_is_seen(tmp_path, monkeypatch):
    monkeypatch.setattr(judge, "MAX_SECONDS", 1e-4)
    assert judged(dawdle, tmp_path / "a").startswith("took 0.")


@pytest.mark.parametrize("read", [refuse, lambda path: None])
def test_reading_and_refusing_are_no_faults(tmp_path, capfd, read):
    assert judged(read, tmp_path / "a") is None
    print("seen")
    assert capfd.readouterr().out == "seen\n"
