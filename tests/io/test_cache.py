import os
from pathlib import Path

import pytest

from caricli.errors import OutputError
from caricli.io.cache import cache_folder


def test_xdg_says_where(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "caricli"


@pytest.mark.parametrize("value", [None, "", "relative/folder", ".", "~/cache"])
def test_only_absolute_paths_count(monkeypatch, tmp_path, value):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    if value is not None:
        monkeypatch.setenv("XDG_CACHE_HOME", value)
    assert cache_folder() == tmp_path / ".cache" / "caricli"
    assert not list(tmp_path.iterdir())


def test_home_may_be_missing(monkeypatch):
    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert cache_folder() == Path(os.path.expanduser("~")) / ".cache" / "caricli"

    def nobody(_):
        raise KeyError("getpwuid(): uid not found")

    monkeypatch.setattr("pwd.getpwuid", nobody)
    with pytest.raises(OutputError, match="expected a home folder or XDG_CACHE_HOME"):
        cache_folder()
