"""What a command says at its end."""

from pathlib import Path

import click

from caricli.commands.shared.waited import waited
from caricli.errors import shown
from caricli.io.parsing import names_labels


def echo_result(line: str, *notes: str | None) -> None:
    """Print what came of it and how long it took, after what is worth knowing besides, on stderr; a note that is None
    is none.
    """
    echo_notes(*notes)
    click.echo(f"{shown(line)}, {waited()}")


def echo_notes(*notes: str | None) -> None:
    """Print what is worth knowing besides, on stderr; a note that is None is none."""
    for note in notes:
        if note:
            click.echo(shown(note), err=True)


def echo_numbering(labels: Path | None) -> None:
    """Say how a label map is read that names no labels. labels: its path, or None where there is none. Raises
    InputError when it is no label map.
    """
    if labels is not None and not names_labels(labels):
        echo_notes(f"{shown(labels)}: nothing names its labels, which are read as numbered in CelebAMask-HQ")
