from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from caricli.commands.shared.batch import named_jobs, run_batch
from caricli.errors import InputError, OutputError
from caricli.io.outputs import staged


@pytest.mark.parametrize(
    ("places", "names"),
    [
        (["heads/ann/face.npz", "heads/bob/face.npz"], ["ann", "bob"]),
        (
            ["a/ann/textured/face.npz", "b/ann/textured/face.npz", "b/bob/face.npz"],
            ["a-ann-textured", "b-ann-textured", "b-bob"],
        ),
        (["ann.png", "deep/bob.jpg"], ["ann", "bob"]),
    ],
)
def test_inputs_of_one_name_are_told_apart_by_their_folders(places, names, tmp_path):
    paths = [tmp_path / place for place in places]
    jobs = named_jobs(paths, "FACE", None, tmp_path / "out", ".obj")
    assert jobs == [(path, tmp_path / "out" / f"{name}.obj") for path, name in zip(paths, names, strict=True)]


@pytest.mark.parametrize("places", [("a.npz", "a.npz"), ("a.npz", "a.obj"), ("b/a.npz", "c/a.npz", "b/a.obj")])
def test_one_face_twice_is_refused(places, tmp_path):
    """In two formats, too."""
    with pytest.raises(click.UsageError, match=r"out/[ab]\.obj: two FACE would be written there"):
        named_jobs([tmp_path / place for place in places], "FACE", None, tmp_path / "out", ".obj")


def test_what_failed_is_named_once():
    @click.command()
    @click.pass_context
    def command(ctx):
        def work(path, message):
            raise InputError(message)

        run_batch(
            ctx, [(Path("a.png"), "a.png: expected a face"), (Path("b.png"), "expected a face")], work, "pictures"
        )

    result = CliRunner().invoke(command)
    assert result.exit_code == 1
    assert "failed: a.png: expected a face\n" in result.stderr and "failed: b.png: expected a face\n" in result.stderr


@pytest.mark.parametrize("overwrite", [False, True])
def test_an_item_never_replaces_what_another_one_wrote(overwrite, tmp_path):
    (tmp_path / "b").write_text("old")

    @click.command()
    @click.pass_context
    def command(ctx):
        def work(path, *names):
            with staged(*(tmp_path / name for name in names), overwrite=overwrite) as files:
                for file in files:
                    file.write_text(path.name)
            return str(path)

        items = [(Path("one"), "a", "a-2"), (Path("two"), "a-2", "a-3"), (Path("three"), "a-3"), (Path("four"), "b")]
        run_batch(ctx, items, work, "pictures")

    for _ in range(1 + overwrite):  # another call replaces what this one wrote
        result = CliRunner().invoke(command)
        assert result.exit_code == 1
        assert "a-2: expected an output of its own, found what was written for one\n" in result.stderr
        assert ("b exists" in result.stderr) != overwrite
        written = {path.name: path.read_text() for path in tmp_path.iterdir()}
        assert written == {"a": "one", "a-2": "one", "a-3": "three", "b": "four" if overwrite else "old"}


def test_names_that_are_not_utf8_are_told_and_end_nothing():
    @click.command()
    @click.pass_context
    def command(ctx):
        def work(path, ending):
            if ending is None:
                raise InputError(f"{path}: expected a face")
            return f"{path}: {ending}"

        run_batch(
            ctx, [(Path("a\udcff.png"), "one"), (Path("b\udcff.png"), None), (Path("c.png"), "two")], work, "pictures"
        )

    result = CliRunner().invoke(command)
    assert result.exit_code == 1 and isinstance(result.exception, SystemExit)
    assert result.stdout.startswith("a\\udcff.png: one, ") and "c.png: two" in result.stdout
    assert "failed: b\\udcff.png: expected a face\n" in result.stderr


def test_what_failed_is_told_where_the_end_fails_too():
    @click.command()
    @click.pass_context
    def command(ctx):
        def work(path):
            raise InputError("expected a face")

        def finish(failures):
            raise OutputError("index.html: cannot be written")

        run_batch(ctx, [(Path("a.png"),), (Path("b.png"),)], work, "pictures", finish)

    result = CliRunner().invoke(command)
    assert isinstance(result.exception, OutputError)
    assert "failed: a.png: expected a face\n" in result.stderr and "failed: b.png" in result.stderr
