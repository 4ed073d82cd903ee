"""Many inputs in one call: one bad item does not stop the others."""

from collections.abc import Callable, Sequence
from pathlib import Path

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import followed
from caricli.commands.shared.progress import progress_bar
from caricli.errors import CaricliError, shown
from caricli.io.distinct_names import distinct_names
from caricli.io.outputs import written_for


def named_jobs(
    inputs: Sequence[Path], noun: str, out: Path | None, out_dir: Path | None, *suffixes: str
) -> list[tuple[Path, Path]]:
    """Pairs of an input and the file to write for it: ``out`` for one, or one in ``out_dir`` under the input's name.

    Inputs of one name are told apart by their folders: ``heads/anna/face.npz`` and ``heads/otto/face.npz`` become
    ``anna`` and ``otto``.
    noun: what the command's help calls an input. suffixes: that files may have, such as ".obj"; those in ``out_dir``
    have the first.
    Raises click.UsageError unless exactly one of out and out_dir fits.
    """
    if (out is None) == (out_dir is None):
        raise click.UsageError("Give either --out for one result or --out-dir for many.")
    if out is not None and out.suffix.lower() not in suffixes:
        raise click.UsageError(f"{shown(out)}: expected a name that ends in {' or '.join(suffixes)}")
    if out is not None and len(inputs) > 1:
        raise click.UsageError(f"--out takes one {noun}; for more use --out-dir.")
    if out is not None:
        return [(path, out) for path in inputs]
    assert out_dir is not None
    targets = [followed(out_dir / f"{name}{suffixes[0]}") for name in distinct_names(inputs, between="-")]
    twice = [target for number, target in enumerate(targets) if target in targets[:number]]
    if twice:
        raise click.UsageError(f"{shown(twice[0])}: two {noun} would be written there.")
    return [*zip(inputs, targets, strict=True)]


def run_batch(
    ctx: click.Context,
    items: Sequence[tuple],
    work: Callable[..., str],
    description: str,
    finish: Callable[[list[tuple[Path, CaricliError]]], None] | None = None,
) -> None:
    """Do the work for every item and say what came of it; failures end as a table and exit code 1.

    items: tuples, the first entry the path that a failure is reported under. work: called with the entries of an item,
    returns the line to print. description: of the progress. finish: called at the end with the items that failed and
    why. A single item fails as any command does. An item never replaces what another one wrote, and fails instead.
    """
    failures: list[tuple[Path, CaricliError]] = []
    writers: dict[Path, Path] = {}
    with progress_bar(description) as report:
        for number, item in enumerate(items):
            try:
                with written_for(item[0], writers):
                    line = work(*item)
                echo_result(line)
            except CaricliError as error:
                if len(items) == 1:
                    raise
                failures.append((item[0], error))
            report(number + 1, len(items))
    for path, failure in failures:
        echo_notes(f"caricli: failed: {_named(path, failure)}")
    if finish is not None:
        finish(failures)
    if failures:
        echo_notes(f"caricli: {len(failures)} of {len(items)} failed")
        ctx.exit(1)


def _named(path: Path, failure: CaricliError) -> str:
    """What failed and why, the path named once: messages about the file itself begin with it."""
    text = shown(failure)
    start = f"{shown(path)}: "
    return text if text.startswith(start) else start + text
