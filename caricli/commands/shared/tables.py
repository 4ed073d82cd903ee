"""Tables that are printed."""

from collections.abc import Iterable, Sequence

import click

from caricli.structures import Directions

WIDTH = 120
"""Columns of a table that is written into a file or a pipe, which do not say how wide they are."""


def print_table(titles: Sequence[str], rows: Iterable[Sequence[str]], title: str | None = None) -> None:
    """Print a table; cells of the first column stay on one line."""
    from rich.console import Console
    from rich.table import Column, Table

    table = Table(Column(titles[0], no_wrap=True), *titles[1:], title=title)
    for row in rows:
        table.add_row(*row)
    Console(width=None if Console().is_terminal else WIDTH).print(table)


def number(value: float | None, digits: int) -> str:
    """A cell: a number with so many digits after the point, "-" for none."""
    return "-" if value is None else f"{value:.{digits}f}"


def print_directions(directions: Directions) -> None:
    """Print names, AUC, counts and changes of directions."""
    width = max(map(len, ("label", *directions.names)))
    click.echo(f"{'label':{width}}    AUC  positives  change")
    for name, row in directions.figures.items():
        click.echo(f"{name:{width}}  {row['auc']:5.3f}  {row['positives']:9}  {row['change']:6.2f}")


def shape_errors(errors: dict) -> str:
    """Text of ShapeErrors by split."""
    figures = ", ".join(f"{split} {error.percent:.3f} %" for split, error in errors.items())
    return f"shape error {figures} of the head's height"


def detector_figures(figures: dict) -> str:
    """Text of the figures of a DetectorTally."""
    text = f"{100 * figures['recall']:.1f} % of {figures['faces']} faces found, {figures['false']} false ones"
    if figures["nme"]:
        text += f", landmarks within {figures['nme']['all']:.2f} % of their diagonal"
    return text
