import errno
import os
import resource
import stat
from contextlib import contextmanager
from pathlib import Path, PurePath

import numpy as np
import pytest

from caricli.errors import InputError, OutputError
from caricli.io import outputs
from caricli.io.checkpoint import write_checkpoint
from caricli.io.face import write_face
from caricli.io.image import write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.obj import write_obj
from caricli.io.npz import write_npz
from caricli.io.outputs import check_outputs, staged, staged_folder, write_bytes
from caricli.io.strict_json import write_json
from caricli.structures import Face, Landmarks, Mesh


def tree(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_outputs_appear_on_success(tmp_path):
    with staged(tmp_path / "a.obj", tmp_path / "new" / "deep" / "b.npz") as (first, second):
        assert (first.name, second.name) == ("a.obj", "b.npz")
        assert not (tmp_path / "a.obj").exists()
        first.write_text("one")
        second.write_text("two")
    assert (tmp_path / "a.obj").read_text() == "one"
    assert tree(tmp_path) == ["a.obj", "new", "new/deep", "new/deep/b.npz"]


def test_outputs_have_the_ordinary_permissions(tmp_path):
    with staged(tmp_path / "a") as (temporary,):
        temporary.write_text("one")
    (tmp_path / "b").write_text("one")
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode
    with staged_folder(tmp_path / "c") as temporary:
        (temporary / "x").write_text("one")
    (tmp_path / "d").mkdir()
    assert stat.S_IMODE((tmp_path / "c").stat().st_mode) == stat.S_IMODE((tmp_path / "d").stat().st_mode)


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, ValueError, OutputError])
def test_nothing_is_left_after_an_exception(tmp_path, error):
    with pytest.raises(error), staged(tmp_path / "new" / "a.obj", tmp_path / "b.npz") as (first, second):
        first.write_text("half")
        raise error
    assert tree(tmp_path) == []
    with pytest.raises(error), staged_folder(tmp_path / "new" / "data") as temporary:
        (temporary / "shard").write_text("half")
        raise error
    assert tree(tmp_path) == []


def test_parents_with_other_content_stay(tmp_path):
    with pytest.raises(KeyboardInterrupt), staged(tmp_path / "new" / "a") as (temporary,):
        (tmp_path / "new" / "other").write_text("someone else's")
        raise KeyboardInterrupt
    assert tree(tmp_path) == ["new", "new/other"]


def test_an_existing_output_needs_overwrite(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("old")
    with pytest.raises(OutputError, match=r"a\.obj exists; give --overwrite to replace it"), staged(path):
        raise AssertionError("the body must not run")
    assert path.read_text() == "old"
    with staged(path, overwrite=True) as (temporary,):
        temporary.write_text("new")
    assert path.read_text() == "new"
    assert tree(tmp_path) == ["a.obj"]


def test_an_output_that_appears_meanwhile_is_kept(tmp_path):
    path = tmp_path / "a.obj"
    with pytest.raises(OutputError, match="exists"), staged(path) as (temporary,):
        temporary.write_text("mine")
        path.write_text("theirs")
    assert path.read_text() == "theirs"
    assert tree(tmp_path) == ["a.obj"]


def test_a_failed_overwrite_keeps_the_old_files(tmp_path, monkeypatch):
    paths = [tmp_path / name for name in "abc"]
    for path in paths[:2]:
        path.write_text("old")
    replace = os.replace

    def failing(source, target):
        if Path(target) == paths[2]:
            raise OSError(errno.EIO, "Input/output error")
        replace(source, target)

    monkeypatch.setattr(outputs.os, "replace", failing)
    with pytest.raises(OutputError, match="Input/output error"), staged(*paths, overwrite=True) as temporaries:
        for temporary in temporaries:
            temporary.write_text("new")
    assert [path.read_text() for path in paths[:2]] == ["old", "old"]
    assert tree(tmp_path) == ["a", "b"]


def test_overwriting_works_without_hard_links(tmp_path, monkeypatch):
    def no_links(source, target):
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(outputs.os, "link", no_links)
    (tmp_path / "a").write_text("old")
    with staged(tmp_path / "a", overwrite=True) as (temporary,):
        temporary.write_text("new")
    assert (tmp_path / "a").read_text() == "new"
    assert tree(tmp_path) == ["a"]


@pytest.mark.parametrize("name", ["in.obj", "./sub/../in.obj", "link.obj", "hard.obj"])
def test_an_output_is_never_an_input(tmp_path, name):
    source = tmp_path / "in.obj"
    source.write_text("precious")
    (tmp_path / "sub").mkdir()
    (tmp_path / "link.obj").symlink_to(source)
    (tmp_path / "hard.obj").hardlink_to(source)
    with (
        pytest.raises(OutputError, match="expected an output, found one of the inputs"),
        staged(tmp_path / name, overwrite=True, inputs=[None, source]),
    ):
        raise AssertionError("the body must not run")
    assert source.read_text() == "precious"


def test_what_goes_beside_an_output_is_never_an_input(tmp_path):
    source = tmp_path / "moods.json"
    source.write_text("precious")
    said = r"moods.json: .*found one of the inputs; it goes beside \S*moods.npz: give that another name"
    with pytest.raises(OutputError, match=said), staged(tmp_path / "moods.npz", source, inputs=[source]):
        raise AssertionError("the body must not run")


def test_other_inputs_do_not_disturb(tmp_path):
    (tmp_path / "in.obj").write_text("in")
    with staged(tmp_path / "out.obj", inputs=[tmp_path / "in.obj", tmp_path / "missing"]) as (temporary,):
        temporary.write_text("out")
    assert tree(tmp_path) == ["in.obj", "out.obj"]


def test_every_path_is_looked_up_once(tmp_path, monkeypatch):
    calls = {"resolved": 0, "compared": 0}
    resolve, equal = os.path.realpath, PurePath.__eq__

    def resolved(path, **options):
        calls["resolved"] += 1
        return resolve(path, **options)

    def compared(first, second):
        calls["compared"] += 1
        return equal(first, second)

    results = [tmp_path / f"{k}.obj" for k in range(200)]
    sources = [tmp_path / f"{k}.jpg" for k in range(50)]
    monkeypatch.setattr(outputs.os.path, "realpath", resolved)
    monkeypatch.setattr(PurePath, "__eq__", compared)
    with pytest.raises(KeyboardInterrupt), staged(*results, inputs=sources):
        assert calls["resolved"] == 250 and calls["compared"] < 1000
        raise KeyboardInterrupt


def test_an_overwritten_link_stays_a_link(tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with staged(tmp_path / "link", overwrite=True) as (temporary,):
        temporary.write_text("new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def test_impossible_outputs(tmp_path):
    (tmp_path / "file").write_text("x")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    cases = {
        tmp_path: "found a folder",
        tmp_path / "pipe": "not a regular file",
        tmp_path / "loop": "not a regular file",
        tmp_path / "loop" / "a.obj": "cannot be written",
        tmp_path / "file" / "a.obj": "cannot be written",
        tmp_path / ("x" * 300): "cannot be written",
        f"{tmp_path}/a\0b": "expected a path",
    }
    for path, message in cases.items():
        with pytest.raises(OutputError, match=message) as caught, staged(path, overwrite=True):
            raise AssertionError("the body must not run")
        assert "\n" not in str(caught.value)
    with pytest.raises(OutputError, match="the same one twice"), staged(tmp_path / "a", tmp_path / "." / "a"):
        raise AssertionError("the body must not run")
    with pytest.raises(OutputError, match="nothing was written"), staged(tmp_path / "a", tmp_path / "b") as (first, _):
        first.write_text("x")
    with pytest.raises(OutputError, match="found a file"), staged_folder(tmp_path / "loop", overwrite=True):
        raise AssertionError("the body must not run")
    assert tree(tmp_path) == ["file", "loop", "pipe"]
    assert os.readlink(tmp_path / "loop") == "loop"


def test_a_link_that_leads_to_itself_counts_as_there(tmp_path):
    with pytest.raises(OutputError, match="exists; give --overwrite"), staged(tmp_path / "a") as (temporary,):
        temporary.write_text("new")
        (tmp_path / "a").symlink_to("a")  # while it was being written
    assert os.readlink(tmp_path / "a") == "a"


def test_a_link_to_what_is_not_there_is_followed(tmp_path):
    (tmp_path / "link").symlink_to("later")
    with staged(tmp_path / "link") as (temporary,):
        temporary.write_text("new")
    assert (tmp_path / "later").read_text() == "new" and (tmp_path / "link").is_symlink()


def test_a_full_disk_while_writing(tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OutputError, match=r"a\.npz: cannot be written: No space left on device") as caught:
        with staged(tmp_path / "a.npz") as (temporary,):
            monkeypatch.setattr(np.lib.format, "write_array", full)
            write_npz(temporary, {"x": np.zeros(3)})
    assert ".caricli-" not in str(caught.value)
    with pytest.raises(OutputError, match=r"b\.png: cannot be written: No space"), staged(tmp_path / "b.png"):
        full()
    assert tree(tmp_path) == []


@contextmanager
def little_room(size):
    """Let no file grow beyond this many bytes: writing fails half-way, as it does on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


NOISE = np.random.default_rng(0).uniform(0, 1000, (4000, 3))
ROWS = np.arange(3999).reshape(-1, 3).astype(np.int32)
WRITERS = {
    "a.obj": lambda path: write_obj(path, Mesh(NOISE, ROWS)),
    "face.npz": lambda path: write_face(path, Face(Mesh(NOISE, ROWS))),
    "a.npz": lambda path: write_npz(path, {"x": NOISE}),
    "a.json": lambda path: write_json(path, NOISE),
    "a.png": lambda path: write_png(path, NOISE.astype(np.uint8)[None]),
    "a.txt": lambda path: write_landmarks(path, Landmarks(NOISE[:68, :2])),
    "a.npy": lambda path: write_landmarks(path, Landmarks(NOISE[:68, :2])),
    "a.safetensors": lambda path: write_checkpoint(path, {"x": NOISE}, {}),
}


@pytest.mark.parametrize("name", WRITERS)
def test_writing_that_fails_half_way(tmp_path, name):
    with pytest.raises(OutputError, match=f"{name}: cannot be written: File too large") as caught:
        with little_room(1000), staged(tmp_path / "new" / name) as (temporary,):
            WRITERS[name](temporary)
    assert ".caricli-" not in str(caught.value)
    assert tree(tmp_path) == []
    with staged(tmp_path / "new" / name) as (temporary,):
        WRITERS[name](temporary)
    assert (tmp_path / "new" / name).stat().st_size > 1000


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_full_disk_at_the_end(tmp_path, monkeypatch, call):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OutputError, match=r"a\.npz: cannot be written: No space left on device"):
        with staged(tmp_path / "new" / "a.npz") as (temporary,):
            write_bytes(temporary, b"x")
            monkeypatch.setattr(outputs.os, call, full)
    assert tree(tmp_path) == []


def test_a_read_only_folder(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied")

    with monkeypatch.context() as patch:
        patch.setattr(outputs.tempfile, "mkdtemp", refuse)
        with pytest.raises(OutputError, match="cannot be written: Permission denied"), staged(tmp_path / "a"):
            raise AssertionError("the body must not run")
    with monkeypatch.context() as patch:
        patch.setattr(outputs.Path, "mkdir", refuse)
        with pytest.raises(OutputError, match="cannot be written: Permission denied"), staged(tmp_path / "new" / "a"):
            raise AssertionError("the body must not run")
    assert tree(tmp_path) == []


def test_outputs_can_be_checked_before_the_work(tmp_path, monkeypatch):
    check_outputs(tmp_path / "new" / "a", tmp_path / "b", inputs=[tmp_path / "c"])
    assert tree(tmp_path) == []
    (tmp_path / "b").write_text("old")
    with pytest.raises(OutputError, match="exists"):
        check_outputs(tmp_path / "new" / "a", tmp_path / "b")
    check_outputs(tmp_path / "b", overwrite=True)
    with pytest.raises(OutputError, match="b: expected an output, found one of the inputs"):
        check_outputs(tmp_path / "a", tmp_path / "b", overwrite=True, inputs=iter([tmp_path / "b"]))

    with pytest.raises(OutputError, match="found the same one twice"):
        check_outputs(tmp_path / "a", tmp_path / "new" / ".." / "a")

    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(outputs.tempfile, "mkdtemp", refuse)
    with pytest.raises(OutputError, match="new: cannot be written: Permission denied"):
        check_outputs(tmp_path / "new" / "a")
    assert tree(tmp_path) == ["b"]


def test_messages_name_outputs_where_they_will_stand(tmp_path):
    for make in (InputError, OutputError):
        with pytest.raises(make) as caught, staged(tmp_path / "a.foo", tmp_path / "b") as (temporary, _):
            raise make(f"{temporary}: expected .json, found '.foo'")
        assert str(caught.value) == f"{tmp_path / 'a.foo'}: expected .json, found '.foo'"
    with pytest.raises(OutputError) as caught, staged_folder(tmp_path / "new") as folder:
        raise OutputError(f"{folder / 'c'}: too large")
    assert str(caught.value) == f"{tmp_path / 'new' / 'c'}: too large"


def test_other_errors_of_the_system_pass(tmp_path):
    with pytest.raises(BrokenPipeError), staged(tmp_path / "a"):
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")
    assert tree(tmp_path) == []


def test_a_folder_appears_whole(tmp_path):
    with staged_folder(tmp_path / "new" / "data") as temporary:
        (temporary / "sub").mkdir()
        (temporary / "sub" / "shard.npz").write_text("x")
        (temporary / "dataset.json").write_text("{}")
        assert not (tmp_path / "new" / "data").exists()
    assert tree(tmp_path / "new") == ["data", "data/dataset.json", "data/sub", "data/sub/shard.npz"]


def test_a_folder_is_replaced_as_a_whole(tmp_path):
    folder = tmp_path / "data"
    folder.mkdir()
    (folder / "old").write_text("old")
    with pytest.raises(OutputError, match="data exists; give --overwrite"), staged_folder(folder):
        raise AssertionError("the body must not run")
    with pytest.raises(KeyboardInterrupt), staged_folder(folder, overwrite=True):
        raise KeyboardInterrupt
    assert tree(tmp_path) == ["data", "data/old"]
    with staged_folder(folder, overwrite=True) as temporary:
        (temporary / "new").write_text("new")
    assert tree(tmp_path) == ["data", "data/new"]


def test_a_failed_replacement_keeps_the_old_folder(tmp_path, monkeypatch):
    folder = tmp_path / "data"
    folder.mkdir()
    (folder / "old").write_text("old")
    replace = os.replace

    def failing(source, target):
        if Path(target) == folder and Path(source).name == "data":
            raise OSError(errno.ENOSPC, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(outputs.os, "replace", failing)
    with pytest.raises(OutputError, match="No space"), staged_folder(folder, overwrite=True) as temporary:
        (temporary / "new").write_text("new")
    assert tree(tmp_path) == ["data", "data/old"]


def test_a_folder_with_other_files_is_not_replaced(tmp_path, monkeypatch):
    folder = tmp_path / "data"
    folder.mkdir()
    with staged_folder(folder, overwrite=True, marker="dataset.json") as temporary:
        (temporary / "x").write_text("x")
    with pytest.raises(OutputError, match="expected a folder with dataset.json to replace"):
        with staged_folder(folder, overwrite=True, marker="dataset.json"):
            raise AssertionError("the body must not run")
    (folder / "dataset.json").write_text("{}")
    with staged_folder(folder, overwrite=True, marker="dataset.json") as temporary:
        (temporary / "y").write_text("y")
    assert tree(folder) == ["y"]
    with pytest.raises(OutputError, match="a folder that holds the input"):
        with staged_folder(folder, overwrite=True, inputs=[folder / "y"]):
            raise AssertionError("the body must not run")
    with pytest.raises(OutputError, match="found one of the inputs"):
        with staged_folder(folder, overwrite=True, inputs=[folder]):
            raise AssertionError("the body must not run")
    with pytest.raises(OutputError, match="found a file"), staged_folder(folder / "y", overwrite=True):
        raise AssertionError("the body must not run")
    monkeypatch.chdir(folder)
    with pytest.raises(OutputError, match="the current or the home folder"), staged_folder("..", overwrite=True):
        raise AssertionError("the body must not run")
    monkeypatch.chdir("/")
    monkeypatch.setenv("HOME", str(folder))
    with pytest.raises(OutputError, match="the current or the home folder"), staged_folder(folder, overwrite=True):
        raise AssertionError("the body must not run")
    assert tree(folder) == ["y"]
