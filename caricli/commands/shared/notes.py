"""What a command says at its end."""

import click


def echo_result(line: str, *notes: str | None) -> None:
    """Print what came of it, after what is worth knowing besides, on stderr; a note that is None is none."""
    for note in notes:
        if note:
            click.echo(note, err=True)
    click.echo(line)
