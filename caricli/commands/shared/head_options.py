"""The options that say what a head consists of, which arrive together."""

from collections.abc import Callable
from functools import wraps
from typing import get_args

import click

from caricli.structures import HeadChoice
from caricli.structures.head_choice import Teeth
from caricli.structures.materials import HEAD_PARTS


def _names(ctx, param, value):
    """The names of parts in a text with commas; the skin is always among them."""
    names = None if value is None else tuple(name.strip() for name in value.split(","))
    unknown = [name for name in names or () if name not in HEAD_PARTS]
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r} is not one of {', '.join(HEAD_PARTS)}.")
    if names is not None and "skin" not in names:
        raise click.BadParameter("'skin' is not among them; all others are in it or on it.")
    return names


def _parts_option(help: str) -> Callable:
    return click.option("--parts", callback=_names, metavar="NAMES", help=help)


_LISTED = f"with commas between them: {', '.join(HEAD_PARTS)}."
_bust_option = click.option("--bust", is_flag=True, help="Put shoulders under the head instead of closing its neck.")
_teeth_option = click.option(
    "--teeth", type=click.Choice(get_args(Teeth)), help="Model teeth so; cartoon ones are fewer and wider.  "
    "[default: natural]",
)  # fmt: skip


def _chosen(parts, bust, teeth):
    """The HeadChoice of what was typed. Raises UsageError for teeth that are not among the parts."""
    if teeth is not None and parts is not None and "teeth" not in parts:
        raise click.UsageError("--teeth are not among --parts: give one of them, or teeth among these.")
    return HeadChoice(parts or tuple(HEAD_PARTS), bust, teeth)


def head_options(command: Callable) -> Callable:
    """Add `--parts`, `--bust` and `--teeth`; they arrive as `head`, a HeadChoice."""

    @_parts_option(f"Make the head of these, {_LISTED}  [default: all that it has]")
    @_bust_option
    @_teeth_option
    @wraps(command)
    def with_choice(*args, parts, bust, teeth, **others):
        return command(*args, head=_chosen(parts, bust, teeth), **others)

    return with_choice


def made_head_options(command: Callable) -> Callable:
    """Add `--parts` and `--bust`, for a head whose teeth are there; they arrive as `head`, a HeadChoice."""

    @_parts_option(f"Leave of the head these, {_LISTED}  [default: all that it has]")
    @_bust_option
    @wraps(command)
    def with_choice(*args, parts, bust, **others):
        return command(*args, head=_chosen(parts, bust, None), **others)

    return with_choice


def mesh_head_options(command: Callable) -> Callable:
    """Add the same as ``head_options`` for a command whose mesh is the skin unless one of them is typed; they arrive
    as `head`, a HeadChoice, or None where none was."""

    @_parts_option(
        f"Make mesh and picture of these, {_LISTED}  [default: the skin in the mesh, which other commands take; all in "
        "the picture]"
    )
    @_bust_option
    @_teeth_option
    @wraps(command)
    def with_choice(*args, parts, bust, teeth, **others):
        typed = parts is not None or bust or teeth is not None
        return command(*args, head=_chosen(parts, bust, teeth) if typed else None, **others)

    return with_choice
