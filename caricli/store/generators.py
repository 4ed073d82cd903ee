"""Users' own painters of pictures: commands, and TorchScript files.

A generator is a program that its user chose, and runs with all that its user may do.
"""

import io
import os
import shlex
import signal
import subprocess
import tempfile
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, UsageError, shown
from caricli.io.files import read_bytes
from caricli.io.image import read_image, write_png
from caricli.limits import MAX_CHECKPOINT_BYTES
from caricli.methods.stylise.stylise_portrait import Generator

SCRIPTS = (".pt", ".pth", ".ts", ".torchscript")
"""Suffixes of TorchScript files."""

PLACES = ("{input}", "{output}")
"""What stands in a command for the files that it reads and writes."""

_LINE = 200  # characters of what a program said


@dataclass(frozen=True, eq=False)
class LoadedGenerator:
    """A painter and the file that it is from, None for a command."""

    paint: Generator
    file: Path | None


def load_generator(text: str, timeout: float) -> LoadedGenerator:
    """Load what maps pictures to pictures of the same size, with the face where it was.

    A TorchScript file (by its suffix, SCRIPTS) maps a float32 tensor (1, 3, H, W) of sRGB from 0 to 1 to another; what
    is beyond 0 and 1 is cut off. Anything else is a command, split into words as a shell does but run without one, with
    `{input}` where the PNG to read and `{output}` where the picture to write belongs.
    timeout: seconds that a command may take.
    Raises UsageError for a command without these places, InputError for a file that is no TorchScript. The painter
    raises InputError where a program cannot be started, takes too long or fails, or what comes back is no picture of
    the same size, or not finite.
    """
    path = Path(text)
    if path.suffix.lower() in SCRIPTS:
        return LoadedGenerator(_script(path), path)
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise UsageError(f"--generator {shown(text, 60)}: expected a command, found {shown(error)}") from None
    missing = [place for place in PLACES if not any(place in word for word in words)]
    if missing:
        raise UsageError(
            f"--generator {shown(text, 60)}: expected a TorchScript file ({', '.join(SCRIPTS)}) or a command with "
            f"{' and '.join(PLACES)}, found none of {' and '.join(missing)}"
        )
    return LoadedGenerator(partial(_run, words, timeout), None)


def _run(words: Sequence[str], timeout: float, picture: np.ndarray) -> np.ndarray:
    """Let a program paint a picture (H, W, 3) uint8."""
    name = f"the generator {shown(words[0], 60)}"
    with tempfile.TemporaryDirectory(prefix="caricli-") as folder:
        given, painted = (Path(folder) / file for file in ("input.png", "output.png"))
        write_png(given, picture)
        typed = [word.replace(PLACES[0], str(given)).replace(PLACES[1], str(painted)) for word in words]
        code, said = _called(typed, timeout, name)
        if code != 0:
            reason = f": {said}" if said else ""
            raise InputError(f"{name}: expected exit 0, found {code}{reason}")
        if not painted.is_file():
            raise InputError(f"{name}: expected a picture in {PLACES[1]}, found none")
        try:
            result = read_image(painted)
        except InputError as error:
            raise InputError(f"{name}: {str(error).replace(str(painted), PLACES[1])}") from None
    _check_size(result.shape[1::-1], picture, name)
    return result


def _called(words: Sequence[str], timeout: float, name: str) -> tuple[int, str]:
    """Run a program. Returns its exit code and the last line that it said on stderr."""
    with tempfile.TemporaryFile() as told:
        try:
            # A session of its own, so that all that it started ends with it.
            process = subprocess.Popen(
                words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=told, start_new_session=True
            )
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(f"{name}: expected a program, which could not be started: {shown(reason)}") from None
        try:
            code = process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise InputError(f"{name}: expected a picture within {timeout:g} s, found none") from None
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        told.seek(max(0, told.seek(0, os.SEEK_END) - 10 * _LINE))
        lines = told.read().decode(errors="replace").strip().splitlines()
    return code, shown(lines[-1], _LINE) if lines else ""


def _script(path: Path) -> Generator:
    """The painter of a TorchScript file."""
    import torch

    data = read_bytes(path, MAX_CHECKPOINT_BYTES, "a TorchScript file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that TorchScript is no longer the newest form
            module = torch.jit.load(io.BytesIO(data), map_location="cpu").eval()
    # What torch raises of a file that is none depends on the file.
    except Exception as error:
        raise InputError(f"{shown(path)}: expected a TorchScript file, found {_first(error)}") from None
    return partial(_painted_by, module, shown(path))


def _painted_by(module: Any, name: str, picture: np.ndarray) -> np.ndarray:
    import torch

    levels = torch.from_numpy(picture.transpose(2, 0, 1)[None].astype(np.float32) / 255)
    try:
        with torch.no_grad():
            result = module(levels)
    except RuntimeError as error:
        raise InputError(f"{name}: expected it to map a picture, but it failed: {_first(error)}") from None
    if not isinstance(result, torch.Tensor) or result.shape[:-2] != (1, 3) or result.ndim != 4:
        kind = tuple(result.shape) if isinstance(result, torch.Tensor) else type(result).__name__
        raise InputError(f"{name}: expected a tensor {tuple(levels.shape)}, found {kind}")
    _check_size((result.shape[3], result.shape[2]), picture, name)
    colours = result[0].detach().float().numpy()
    if not np.isfinite(colours).all():
        raise InputError(f"{name}: expected finite colours, found {np.sum(~np.isfinite(colours))} that are not")
    return np.round(255 * np.clip(colours, 0, 1)).astype(np.uint8).transpose(1, 2, 0).copy()


def _check_size(size: Sequence[int], picture: np.ndarray, name: str) -> None:
    """Refuse a picture of another (width, height) than the one that was given."""
    height, width = picture.shape[:2]
    if tuple(size) != (width, height):
        raise InputError(f"{name}: expected a picture of {width} x {height} pixels, found {size[0]} x {size[1]}")


def _first(error: BaseException) -> str:
    """The line of torch's message that says what is wrong."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return shown((lines or [type(error).__name__])[-1], _LINE)
