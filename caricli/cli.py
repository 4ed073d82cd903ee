"""The command line: a table of commands, each imported only when it is called, and the one place where failures end."""

import errno
import importlib
import importlib.util
import json
import os
import signal
import sys
import traceback
from itertools import takewhile
from typing import Any

import click

from caricli import __version__, signals
from caricli.errors import CaricliError, UsageError

# What is typed: (module in caricli.commands, or None for a group; section of the help; short help).
COMMANDS = {
    "portrait": ("portrait", "Reconstruct", "Make textured, rigged heads of pictures."),
    "detect": ("detect", "Reconstruct", "Find faces and landmarks in pictures."),
    "stylise": ("stylise", "Reconstruct", "Make a portrait a caricature, and paint it."),
    "reconstruct-from-landmarks": (
        "reconstruct_from_landmarks",
        "Reconstruct",
        "Reconstruct a 3D caricature from 2D landmarks.",
    ),
    "reconstruct-from-sketch": (
        "reconstruct_from_sketch",
        "Reconstruct",
        "Reconstruct a 3D face from a drawing of lines.",
    ),
    "fit-coarse": ("fit_coarse", "Reconstruct", "Let a network see a morphable face in a picture."),
    "fit-morphable": ("fit_morphable", "Reconstruct", "Fit the morphable model to 2D landmarks."),
    "refine": ("refine", "Reconstruct", "Move a face exactly onto its landmarks."),
    "texture": ("texture", "Reconstruct", "Paint a face on all sides with its picture."),
    "encode": ("encode", "Faces", "Find the latent of a mesh in a model."),
    "sample": ("sample", "Faces", "Draw random faces from a model."),
    "interpolate": ("interpolate", "Faces", "Go from one face to another in steps."),
    "map-landmarks": ("map_landmarks", "Edit", "Turn a caricature's landmarks normal, or back."),
    "edit-handle": ("edit_handle", "Edit", "Pull points of a face and let the rest follow."),
    "refine-gesture": ("refine_gesture", "Edit", "Change a face by strokes of the pen on it."),
    "edit-semantic": ("edit_semantic", "Edit", "Change a face by labels such as BigNose."),
    "caricaturize": ("caricaturize", "Edit", "Make a caricature of a regular face."),
    "studio": ("studio", "Edit", "Draw a face and change it by hand, on a page."),
    "rig": ("rig", "Rig", "Give a face the 52 expressions of ARKit."),
    "blendshapes": ("blendshapes", "Rig", "Make expressions that keep who a face is."),
    "retarget": ("retarget", "Rig", "Let a caricature do what a normal face does."),
    "animate": ("animate", "Rig", "Move a rig by the weights of a face tracker."),
    "train": (None, "Models", "Train a shape model on a dataset."),
    "train pca": ("train.pca", "Models", "Train a linear model of vertex positions."),
    "train intrinsic": ("train.intrinsic", "Models", "Train a model of deformations, which does not tear."),
    "train kernel": ("train.kernel", "Models", "Train components that predict finer ones."),
    "train bilinear": ("train.bilinear", "Models", "Train who somebody is times what the face does."),
    "train morphable": ("train.morphable", "Models", "Train linear bases of identity and expression."),
    "train deformable": ("train.deformable", "Models", "Train a network that is continuous over the surface."),
    "train semantic": ("train.semantic", "Models", "Find the directions of labels in a model's latents."),
    "train landmark-map": (
        "train.landmark_map",
        "Models",
        "Train a map between landmarks of normal faces and caricatures.",
    ),
    "train sketch": ("train.sketch", "Models", "Train the network from sketches to faces."),
    "train strokes": ("train.strokes", "Models", "Train the network that tells what strokes draw."),
    "train coarse": ("train.coarse", "Models", "Train the network from pictures to faces of the morphable model."),
    "train style": ("train.style", "Models", "Train the network that gives textures the style of drawings."),
    "train texture": ("train.texture", "Models", "Train the network that paints textures of other expressions."),
    "train gesture": ("train.gesture", "Models", "Train the network that tells pen gestures apart."),
    "train detector": ("train.detector", "Models", "Train the network that finds faces in pictures."),
    "evaluate": (None, "Models", "Compare models and methods on a dataset."),
    "evaluate shape": ("evaluate.shape", "Models", "Compare the shape errors of models."),
    "evaluate ablation": ("evaluate.ablation", "Models", "Compare the deformable model with its rivals."),
    "evaluate portrait": ("evaluate.portrait", "Models", "Compare faces that were reconstructed from portraits."),
    "evaluate blendshapes": (
        "evaluate.blendshapes",
        "Models",
        "Compare expressions of caricatures with the true ones.",
    ),
    "evaluate texture": ("evaluate.texture", "Models", "Compare textures of other expressions with the true ones."),
    "evaluate detector": ("evaluate.detector", "Models", "Measure a detector on pictures whose truth is known."),
    "evaluate gesture": ("evaluate.gesture", "Models", "Measure how pen gestures are told apart."),
    "evaluate sketch": ("evaluate.sketch", "Models", "Compare faces from sketches with the true ones."),
    "dataset": (None, "Data", "Build, import or look at a dataset of faces."),
    "dataset build": ("dataset.build", "Data", "Generate caricatures from the open head model."),
    "dataset import": ("dataset.import_", "Data", "Import a folder of registered meshes."),
    "dataset pictures": ("dataset.pictures", "Data", "Draw pictures of the faces, with all that is known of them."),
    "dataset sketches": ("dataset.sketches", "Data", "Draw sketches of the faces, as many hands would."),
    "dataset show": ("dataset.show", "Data", "Draw a contact sheet and print what is in it."),
    "dataset textures": ("dataset.textures", "Data", "Take textures of the faces with many expressions."),
    "template": (None, "Data", "Export the head that every face is made from."),
    "template export": ("template.export", "Data", "Write the head as a mesh."),
    "render": ("render", "Look", "Draw shaded pictures of faces."),
    "sketch": ("sketch", "Look", "Draw a face as lines."),
    "inspect": ("inspect", "Look", "Say what a file holds, and whether it is whole."),
}

_THREADED = ("Models", "Data")
"""Sections whose matrices are large. In the others threads would wait for each other twice as long as they work."""


class LazyGroup(click.Group):
    """The commands of the table that start with `prefix`; a command's module is imported when it is called."""

    def __init__(self, name: str | None = None, *, prefix: str = "", **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self.prefix = prefix

    def _entries(self) -> dict[str, tuple]:
        """Return the entries one level below this group, by the last word of their name."""
        names = {name: name.removeprefix(self.prefix) for name in COMMANDS if name.startswith(self.prefix)}
        return {last: COMMANDS[name] for name, last in names.items() if " " not in last}

    def list_commands(self, ctx):
        """Return the names in the order of the table."""
        return list(self._entries())

    def get_command(self, ctx, cmd_name):
        """Return the command or subgroup named `cmd_name`, or None."""
        if cmd_name not in self._entries():
            return None
        module, section, short_help = self._entries()[cmd_name]
        if module is None:
            return LazyGroup(cmd_name, prefix=f"{self.prefix}{cmd_name} ", help=short_help)
        if section not in _THREADED:
            # Read when NumPy and PyTorch are imported, which commands do. Threads that spin while they wait for others
            # take these their processor where there is other work.
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
            os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
        _put_off("numpy.f2py", "numpy.testing")
        return importlib.import_module(f"caricli.commands.{module}").command

    def format_commands(self, ctx, formatter):
        """Write the list of commands by section, from the table alone."""
        sections = {}
        for name, (_, section, short_help) in self._entries().items():
            sections.setdefault("Commands" if self.prefix else section, []).append((name, short_help))
        width = max(len(name) for name in self._entries())
        for section, rows in sections.items():
            with formatter.section(section):
                formatter.write_dl([(name.ljust(width), short_help) for name, short_help in rows])


def _put_off(*names):
    """Let modules of a package be imported when something is asked of them.

    SciPy takes all that NumPy offers, its tools for Fortran and for tests among it, which are a third of its start.
    """
    for name in names:
        package, _, last = name.rpartition(".")
        if name not in sys.modules:
            spec = importlib.util.find_spec(name)
            loader = spec.loader = importlib.util.LazyLoader(spec.loader)
            module = sys.modules[name] = importlib.util.module_from_spec(spec)
            loader.exec_module(module)
            setattr(sys.modules[package], last, module)


class Caricli(LazyGroup):
    """The outermost group: turns every failure into one line and an exit code."""

    def main(self, args=None, prog_name="caricli", **extra):
        """Run `args` (default: the process's own) and exit: 0 done, 1 failed, 2 wrong usage, 130 or 143 on a signal."""
        args = list(sys.argv[1:] if args is None else args)
        # Read by hand because they must count even where parsing itself fails; all options of the group are flags.
        flags = set(takewhile(lambda arg: arg.startswith("-"), args))
        try:
            with signals.raising():
                status = super().main(args, prog_name, standalone_mode=False, **extra)
                sys.stdout.flush()
        except (Exception, signals.Stopped) as error:
            sys.exit(_report(error, debug="--debug" in flags, as_json="--json-errors" in flags))
        sys.exit(status if isinstance(status, int) else 0)  # an int is the code given to ctx.exit

    def invoke(self, ctx):
        """Call the command that was typed."""
        try:
            return super().invoke(ctx)
        except EOFError as error:  # click would take it for an end of input at a prompt; caricli never asks
            raise RuntimeError(f"EOFError: {error}") from error


@click.group(
    "caricli",
    cls=Caricli,
    context_settings={"help_option_names": ["-h", "--help"], "show_default": True, "max_content_width": 100},
)
@click.version_option(__version__, prog_name="caricli")
@click.option("--debug", is_flag=True, expose_value=False, help="Show the traceback of a failure.")
@click.option("--json-errors", is_flag=True, expose_value=False, help="Report a failure as one JSON object on stderr.")
def cli():
    """Make 3D caricature and cartoon faces from drawings, portraits and landmarks.

    \b
    Example:
      caricli portrait drawing.png --out-dir heads
    """


def _report(error: BaseException, debug: bool, as_json: bool) -> int:
    """Say on stderr what went wrong and return the exit code."""
    if isinstance(error, BrokenPipeError):  # the reader of our output left; there is nobody to tell
        sys.stdout = open(os.devnull, "w")  # or the interpreter's own flush at exit would complain
        return 1
    if isinstance(error, click.exceptions.NoArgsIsHelpError) and not as_json:
        error.show()
        return error.exit_code
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # for what is still to be flushed
    kind, message, code = _kind_message_code(error)
    # Whatever a file name or a library puts into a message, it stays one printable line.
    message = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in " ".join(message.split()))
    trace = "".join(traceback.format_exception(error)) if debug else ""
    if as_json:
        click.echo(json.dumps({"error": kind, "message": message} | ({"traceback": trace} if trace else {})), err=True)
    else:
        click.echo(f"{trace}caricli: error: {message}", err=True)
    return code


def _kind_message_code(error: BaseException) -> tuple[str, str, int]:
    """Return the kind of failure for programs, the message for people, and the exit code."""
    match error:
        case CaricliError():
            code = 2 if isinstance(error, UsageError) else 1
            return type(error).__name__.removesuffix("Error").lower(), str(error), code
        case click.exceptions.NoArgsIsHelpError():
            return "usage", "no command given; see --help", error.exit_code
        case click.UsageError():
            help_of = f"; see {error.ctx.command_path} --help" if error.ctx else ""
            return "usage", error.format_message().strip().removesuffix(".") + help_of, error.exit_code
        case click.ClickException():
            return "failed", error.format_message(), error.exit_code
        case signals.Stopped():
            return "stopped", f"stopped by {signal.Signals(error.number).name}", 128 + error.number
        case click.Abort():
            return "stopped", "stopped by SIGINT", 130
        case MemoryError():
            return "memory", f"out of memory{f': {error}' if str(error) else ''}", 1
        case OSError(errno=errno.EBADF):
            return "system", "standard output is closed", 1
        case OSError() if error.strerror:
            return "system", f"{error.filename}: {error.strerror}" if error.filename else error.strerror, 1
        case _:
            bug = f"unexpected {type(error).__name__}: {error} (a bug in caricli; `caricli --debug` shows where)"
            return "bug", bug, 1
