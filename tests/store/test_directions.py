from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.io.directions import write_directions
from caricli.store.directions import directions_path, load_directions
from caricli.store.models import load_model


@pytest.fixture(scope="module")
def kernel():
    return load_model(kind="kernel")


def test_the_bundled_directions_of_a_kind(kernel, tmp_path):
    path = directions_path(None, kernel)
    assert path == asset_path("directions-kernel.npz") and "BigNose" in load_directions(kernel, path).names
    assert directions_path(tmp_path / "mine.npz", kernel) == tmp_path / "mine.npz"


def test_a_kind_without_bundled_directions():
    with pytest.raises(InputError, match="no bundled directions for strange models; give --directions"):
        directions_path(None, SimpleNamespace(kind="strange"))


def test_directions_of_another_model_or_length_are_refused(kernel, tmp_path):
    bundled = load_directions(kernel)
    path = tmp_path / "other.npz"
    write_directions(path, replace(bundled, model_id="0" * 64))
    with pytest.raises(InputError, match="other.npz: its directions are of the model 0000.* not of the bundled kernel"):
        load_directions(kernel, path)
    few = np.eye(len(bundled.names), len(bundled.names))
    write_directions(path, replace(bundled, normals=few, gradients=few, people=few))
    with pytest.raises(InputError, match=f"of 128 numbers, found {len(few)}"):
        load_directions(kernel, path)
