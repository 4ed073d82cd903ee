"""The picture that a command draws of its result, unless it is told not to."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import click
import numpy as np

from caricli.commands.shared.options import refuse_typed
from caricli.io.image import write_png

SIZE = 320
"""Pixels, width and height of a view in the picture, where a command has no reason for more or fewer."""

_KEY = "caricli.picture"


def _keep(ctx: click.Context, param: click.Parameter, value: bool) -> bool:
    ctx.meta[_KEY] = value
    return value


picture_option = click.option(
    "--picture/--no-picture",
    default=True,
    expose_value=False,
    callback=_keep,
    help="Draw a picture of the result, or save the time.",
)

no_picture_option = click.option(
    "--no-picture",
    "picture_of_result",
    flag_value=False,
    type=bool,
    default=True,
    show_default=False,
    expose_value=False,
    callback=_keep,
    help="Draw no picture of the result, which saves the time.",
)
"""The same for commands that take a picture."""


def refuse_undrawn(*names: str) -> None:
    """Refuse options of the picture that were typed beside --no-picture. names: of parameters, as they are typed.

    Raises click.UsageError.
    """
    if not picture_files(Path()):
        options = " and ".join(f"--{name}" for name in names)
        refuse_typed(f"--no-picture leaves out what {options} would draw.", *names)


@contextmanager
def without_picture() -> Iterator[None]:
    """Let what is called inside draw no picture."""
    meta = click.get_current_context().meta
    before = meta.get(_KEY, True)
    meta[_KEY] = False
    try:
        yield
    finally:
        meta[_KEY] = before


def picture_files(path: Path) -> list[Path]:
    """The file of the picture, or nothing where none is wanted."""
    context = click.get_current_context(silent=True)
    return [] if context is not None and not context.meta.get(_KEY, True) else [path]


def write_picture(path: Path | None, draw: Callable[[], np.ndarray]) -> None:
    """Draw a picture (H, W, 3) uint8 and write it, where there is a path. Raises OutputError."""
    if path is not None:
        write_png(path, draw())
