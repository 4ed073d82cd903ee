"""Where a result comes from: command, version, inputs with SHA-256, seed."""

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from caricli import __version__
from caricli.io.files import opened
from caricli.io.outputs import final_name


def sha256_file(path: str | Path) -> str:
    """The SHA-256 of a file as 64 hexadecimal digits.

    Raises InputError when it is no regular file or cannot be read.
    """
    with opened(path, "a file") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def sha256_files(paths: Iterable[str | Path]) -> str:
    """One SHA-256 of files in their order, as 64 hexadecimal digits. Raises InputError as ``sha256_file``."""
    return hashlib.sha256("".join(map(sha256_file, paths)).encode()).hexdigest()


def provenance(
    command: str, inputs: Iterable[Path | str | None], seed: int | None = None, **more: Any
) -> dict[str, Any]:
    """Describe a run so that it can be repeated; the same inputs give the same description, so it holds no times.

    command: its name. inputs: paths of files (of a dataset its dataset.json; None entries are skipped). seed: None
    where there is no randomness. more: further entries with JSON values.
    Returns command, version, inputs (SHA-256 by path as given; what is staged by where it will stand), seed where there
    is one, and more.
    Raises InputError when an input cannot be read.
    """
    value: dict[str, Any] = {
        "command": command,
        "version": __version__,
        "inputs": {_text(p): sha256_file(Path(p)) for p in inputs if p is not None},
    }
    if seed is not None:
        value["seed"] = int(seed)
    return value | more


def made_of(recipe: Any, path: str | Path) -> bool:
    """Whether a file is one of the inputs of a recipe, which may be no description of a run at all.

    Raises InputError when the file cannot be read.
    """
    inputs = recipe.get("inputs") if isinstance(recipe, dict) else None
    return isinstance(inputs, dict) and sha256_file(path) in inputs.values()


def _text(path: Path | str) -> str:
    """A path that is not UTF-8 has no JSON form."""
    name = final_name(path) if isinstance(path, Path) else path
    return os.fsencode(name).decode("utf-8", "replace")
