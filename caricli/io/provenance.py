"""Where a result comes from: command, version, inputs with SHA-256, seed."""

import hashlib
import os

from caricli import __version__
from caricli.errors import InputError, shown


def sha256_file(path):
    """Return the SHA-256 of a file as 64 hexadecimal digits.

    Raises: InputError when it cannot be read.
    """
    try:
        with open(path, "rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{shown(path)}: expected a file, but it cannot be read: {shown(reason)}") from error


def provenance(command, inputs, seed=None, **more):
    """Describe a run so that it can be repeated; the same inputs give the same description, so it holds no times.

    Parameters: command, its name; inputs, paths of files (of a dataset its dataset.json; None entries are skipped);
    seed, or None where there is no randomness; more, further entries with JSON values.
    Returns: dict with command, version, inputs (path as given: SHA-256), seed where there is one, and more.
    Raises: InputError when an input cannot be read.
    """
    value = {
        "command": command,
        "version": __version__,
        # A path that is not UTF-8 has no JSON form.
        "inputs": {os.fsencode(p).decode("utf-8", "replace"): sha256_file(p) for p in inputs if p is not None},
    }
    if seed is not None:
        value["seed"] = int(seed)
    return value | more
