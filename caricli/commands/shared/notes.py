"""What a command says at its end."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from caricli.commands.shared.waited import waited
from caricli.errors import shown
from caricli.io.parsing import names_labels
from caricli.structures import Face

if TYPE_CHECKING:
    from caricli.template.template import Template


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


def echo_edited(path: Path, face: Face, template: "Template", effect: str) -> None:
    """Say so where a face is no longer as it was fitted to its picture. path: of the face. effect: of that here."""
    from caricli.methods.texture.edited_since_fit import NOTICED, edited_since_fit

    share = 0.0 if face.landmarks is None else edited_since_fit(face, template)
    if share > NOTICED:
        away = f"landmarks are up to {100 * share:.1f} % of their diagonal away"
        echo_notes(f"{shown(path)}: was edited after it was fitted: {away}, and {effect}")
