"""Options that several commands share, so that the same thing has the same name, type and help everywhere.

A command module holds one `click.Command` named `command`. Its docstring is the help: one line, what it does, and a
block that starts with click's `\\b` and `Example:` and shows the command as it is typed. Commands return None; they say
that something failed by raising a `CaricliError`. Paths are not checked here: the reader knows what it expects, and a
missing file is a failure (exit 1), not wrong usage (exit 2).
"""

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import click
from click.core import ParameterSource

from caricli.errors import UsageError, shown
from caricli.io.image import is_image_file
from caricli.io.parse_number import parse_number, parse_whole

PATH = click.Path(path_type=Path)


class FiniteRange(click.FloatRange):
    """A range of finite numbers in plain decimal digits, as ``parse_number`` takes them."""

    def convert(self, value, param, ctx):
        """Turn the text into a number in the range."""
        return super().convert(_parsed(self, parse_number, value, param, ctx), param, ctx)


class WholeRange(click.IntRange):
    """A range of whole numbers in plain decimal digits, as ``parse_whole`` takes them."""

    def convert(self, value, param, ctx):
        """Turn the text into a number in the range."""
        return super().convert(_parsed(self, parse_whole, value, param, ctx), param, ctx)


def _parsed(kind, parse, value, param, ctx):
    """The number of a text; what is no text is a number already."""
    try:
        return parse(value) if isinstance(value, str) else value
    except ValueError as error:
        return kind.fail(f"{value!r} is {error}.", param, ctx)


def followed(path: Path) -> Path:
    """Where an output goes whose path is a link: what is named after it has to lie beside the file, not the link."""
    return Path(os.path.realpath(path)) if os.path.islink(path) else path


def _followed(ctx, param, value):
    """``followed`` for an option."""
    return None if value is None else followed(value)


def named(*suffixes: str) -> Callable:
    """Return a click callback that follows a link, and refuses an output whose name ends in none of `suffixes`, such as
    ".png".
    """

    def check(ctx, param, value):
        value = _followed(ctx, param, value)
        # A folder has its own refusal.
        if value is not None and value.suffix.lower() not in suffixes and not value.is_dir():
            raise UsageError(f"{shown(value)}: expected a name that ends in {' or '.join(suffixes)}")
        return value

    return check


def named_mesh(ctx, param, value):
    """Refuse a file whose name ends in no suffix of a mesh."""
    from caricli.io.meshes.mesh import MESH_SUFFIXES

    return named(*MESH_SUFFIXES)(ctx, param, value)


FACE_FILES = "as .obj, .ply, .stl, .glb or .gltf; .npz, .json and .png of the same name go beside it."
"""End of the help of an option that names the mesh among the files of a face."""


def refuse_typed(message: str, *names: str) -> None:
    """Refuse options that were typed where they say nothing. names: of parameters. Raises click.UsageError."""
    context = click.get_current_context()
    if any(context.get_parameter_source(name) is ParameterSource.COMMANDLINE for name in names):
        raise click.UsageError(message)


def refuse_unread(paths: Sequence[Path], image: Path | None = None) -> None:
    """Refuse --detector where there is no picture, and --pts-origin where there are no .pts files.

    paths: of pictures, landmarks or meshes. image: path of the picture of landmarks, or None. Raises click.UsageError.
    """
    # What is not there is told when it is read.
    if image is None and not any(is_image_file(path) or not path.is_file() for path in paths):
        refuse_typed("--detector is for pictures.", "detector")
    if all(path.suffix.lower() != ".pts" for path in paths):
        refuse_typed("--pts-origin is for .pts files.", "pts_origin")


def named_numbers(
    option: str, texts: Sequence[str], expected: str, noun: str, limits: tuple[float, float] | None = None
) -> dict[str, float]:
    """Numbers by name, of an option that is repeated with NAME=NUMBER.

    option: as it is typed. texts: its values. expected: what a message says of their form, with an example. noun: what
    the names are names of. limits: smallest and largest number, or None for any.
    Raises UsageError for another form, another number, and a name that is there twice.
    """
    numbers = {}
    for text in texts:
        name, _, value = text.rpartition("=")
        try:
            number = parse_number(value)
        except ValueError:
            raise UsageError(f"{option} {text}: expected {expected}") from None
        if not name:
            raise UsageError(f"{option} {text}: expected {expected}, found the {noun} ''")
        if limits is not None and not limits[0] <= number <= limits[1]:
            raise UsageError(f"{option} {text}: expected {expected}")
        numbers[name] = number
    if len(numbers) < len(texts):
        raise UsageError(f"{option}: expected every {noun} once, found {' '.join(texts)}")
    return numbers


overwrite_option = click.option("--overwrite", is_flag=True, help="Replace outputs that exist.")

seed_option = click.option(
    "--seed",
    type=WholeRange(0, 2**32 - 1),
    default=0,
    help="Draw from this seed; the same one gives the same bytes on the same machine.",
)

workers_option = click.option(
    "--workers", type=WholeRange(min=1), metavar="N", help="Work in N processes.  [default: one per usable core]"
)


def bundled(ctx, param, value):
    """Take the name of a model that comes with caricli, such as "pca", for its file; a file of that name goes first."""
    from caricli.store.models import model_path

    return None if value is None else model_path(value)


def each_bundled(ctx, param, values):
    """``bundled`` for an argument of many models."""
    return tuple(bundled(ctx, param, value) for value in values)


model_option = click.option(
    "--model",
    type=PATH,
    metavar="MODEL",
    callback=bundled,
    help="Use this model: a file, or the kind of one that comes with caricli, such as pca.  [default: the best for the "
    "task]",
)

directions_option = click.option(
    "--directions",
    type=PATH,
    metavar="FILE",
    help="Read the directions of labels from this file of `caricli train semantic`.  [default: those of the model]",
)

subdivide_option = click.option(
    "--subdivide",
    "levels",
    type=WholeRange(0, 4),
    default=0,
    metavar="N",
    help="Split every polygon of the mesh N times; the NPZ keeps the model's own mesh for the next command.",
)

image_option = click.option(
    "--image", type=PATH, metavar="IMAGE", help="Show the result with this picture, to which the landmarks belong."
)

detector_option = click.option(
    "--detector",
    type=PATH,
    metavar="FILE",
    help="Find faces in pictures with this detector of `caricli train detector`.  [default: caricli's]",
)

pts_origin_option = click.option(
    "--pts-origin", type=WholeRange(0, 1), default=1, help="Count the pixels of .pts files from 0 or from 1."
)

device_option = click.option(
    "--device",
    type=click.Choice(["auto", "cpu", "cuda"]),
    default="auto",
    help="Train on this device; auto takes a GPU where there is one.",
)

data_option = click.option(
    "--data", "dataset", type=PATH, metavar="DATASET", required=True, help="Use the dataset in this folder."
)

config_option = click.option(
    "--config", type=PATH, metavar="YAML", help="Read settings from this file, such as those in configs/."
)

set_option = click.option(
    "--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Change one setting by its name; repeat for more."
)


def datasets_option(help: str) -> Callable:
    """Return the option `--data` for one dataset or more; they arrive as `datasets`."""
    return click.option("--data", "datasets", type=PATH, metavar="DATASET", required=True, multiple=True, help=help)


def out_option(
    metavar: str, help: str, required: bool = True, suffix: str | None = None, check: Callable | None = None
) -> Callable:
    """Return the option `-o`, `--out` for the output file or folder that `metavar` names; it arrives as `out`.

    suffix: that its name must end in, if any. check: a callback of click instead, such as ``named_mesh``.
    """
    check = named(suffix) if suffix else check or _followed
    return click.option("-o", "--out", type=PATH, metavar=metavar, required=required, help=help, callback=check)


def out_folder_option(help: str, required: bool = False) -> Callable:
    """Return the option `--out-dir`, a folder for the results of many inputs; it arrives as `out_dir`."""
    return click.option("--out-dir", type=PATH, metavar="DIR", help=help, required=required)
