import io
import os
import zipfile
from contextlib import suppress

import pytest
import torch

from caricli.errors import InputError
from caricli.io.training_state import SCHEMA, read_state, write_state

WEIGHTS = torch.arange(3.0)
STATE = {"weights": WEIGHTS, "counters": [1, 0.5]}


def saved(value, **options):
    stream = io.BytesIO()
    torch.save(value, stream, **options)
    return stream.getvalue()


def packed(data):
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as copy:
        for name in archive.namelist():
            copy.writestr(name, archive.read(name))
    return stream.getvalue()


def test_round_trip(tmp_path):
    write_state(tmp_path / "state.pt", STATE, {"config": {}})
    state, recipe = read_state(tmp_path / "state.pt")
    assert torch.equal(state["weights"], WEIGHTS)
    assert state["counters"] == [1, 0.5] and recipe == {"config": {}}


GOOD = saved({"schema": SCHEMA, "recipe": {}, "state": {}})


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "found an empty file"),
        (b"mine", "damaged or other file"),
        (b"\x80\x02K\x01q\x010q\x02.", "damaged or other file"),
        (GOOD[: len(GOOD) // 2], "damaged or other file"),
        (packed(GOOD), "damaged or other file"),
        (saved({"schema": SCHEMA}, _use_new_zipfile_serialization=False), "damaged or other file"),
        (saved({"schema": SCHEMA, "state": {}, "recipe": os.system}), "damaged or other file"),
        (saved([SCHEMA]), "of schema 'caricli.training/1', found 'None'"),
        (saved({"schema": "other"}), "found 'other'"),
        (saved({"schema": SCHEMA, "recipe": {}}), "a training with its state, found none"),
        (saved({"schema": SCHEMA, "recipe": 3, "state": {}}), "a training with its recipe, found none"),
    ],
)
def test_what_is_no_state_is_refused(tmp_path, data, words):
    (tmp_path / "state.pt").write_bytes(data)
    with pytest.raises(InputError, match=f"state.pt: expected .*{words}"):
        read_state(tmp_path / "state.pt")


def test_what_torch_wonders_about_is_said_by_the_error_alone(tmp_path, recwarn):
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(GOOD)) as archive, zipfile.ZipFile(stream, "w") as copy:
        for name in archive.namelist():
            copy.writestr(name, archive.read(name).replace(b"\x80\x02", b"\x80\x12", 1))
    (tmp_path / "state.pt").write_bytes(stream.getvalue())
    with suppress(InputError):
        read_state(tmp_path / "state.pt")
    assert not recwarn.list


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "state.pt")
    with pytest.raises(InputError, match="not a regular file"):
        read_state(tmp_path / "state.pt")
