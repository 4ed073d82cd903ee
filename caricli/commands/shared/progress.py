"""Bars for what takes its time."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.progress import Progress

_shown: list["Progress"] = []


@contextmanager
def progress_bar(description: str) -> Iterator[Callable[[int, int], None]]:
    """Yield ``report(done, total)``: a bar with the time left on stderr where that is a terminal, else nothing.

    Until it is called for the first time the bar only shows that something is being done. One inside of another is a
    line below it.
    """
    if not sys.stderr.isatty():
        # What draws bars is slow to import.
        yield lambda done, total: None
        return
    with _shown_bars() as progress:
        task = progress.add_task(description, total=None)
        try:
            yield lambda done, total: progress.update(task, completed=done, total=total)
        finally:
            progress.remove_task(task)


@contextmanager
def _shown_bars() -> Iterator["Progress"]:
    """The bars that are shown, or new ones where none are."""
    if _shown:
        yield _shown[-1]
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        _shown.append(progress)
        try:
            yield progress
        finally:
            _shown.pop()


@contextmanager
def training_bar(epochs: int, quiet: bool = False) -> Iterator[Callable[[dict], None]]:
    """Yield show(line of the log): a bar with loss and errors where stderr is a terminal, else lines now and then.

    quiet: say nothing, because another process of the same training does.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
    with Progress(*columns, console=console, disable=quiet or not console.is_terminal, transient=True) as progress:
        task = progress.add_task("", total=epochs)
        validation = ""
        start = time.monotonic()
        first = 0

        def show(line: dict) -> None:
            nonlocal validation, first
            first = first or line["epoch"]
            if line["validation"] is not None:
                validation = f", validation {line['validation']:.3f} %"
            text = f"loss {line['loss']:.4g}, train {line['train']:.3f} %{validation}"
            progress.update(task, completed=line["epoch"], description=text)
            if line["validation"] is not None and not console.is_terminal and not quiet:
                done = line["epoch"] - first + 1
                minutes = (time.monotonic() - start) / 60 / done * (epochs - line["epoch"])
                click.echo(
                    f"epoch {line['epoch']} of {epochs}: {text}, about {minutes:.0f} min left, then measuring", err=True
                )

        yield show
