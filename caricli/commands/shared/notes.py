"""What a command says at its end."""

import click

from caricli.commands.shared.waited import waited
from caricli.errors import shown


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
