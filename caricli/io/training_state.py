"""What a training needs to go on: tensors and counters in one file, loaded without running code."""

import pickle
from pathlib import Path
from typing import Any

from caricli.errors import InputError, shown
from caricli.io.outputs import staged, writing

SCHEMA = "caricli.training/1"
# What torch.load raises for a file that it cannot make sense of.
_DAMAGE = OSError, RuntimeError, pickle.UnpicklingError, EOFError, KeyError, TypeError, ValueError, AttributeError


def write_state(path: str | Path, state: dict, recipe: Any) -> None:
    """Replace the state of a training at once: killed while it writes, the one before stays.

    state: tensors, numbers, lists and dicts by name. recipe: JSON value, what is being trained.
    Raises OutputError when it cannot be written.
    """
    import torch

    with staged(path, overwrite=True) as (temporary,), writing(temporary), open(temporary, "wb") as stream:
        torch.save({"schema": SCHEMA, "recipe": recipe, "state": state}, stream)


def read_state(path: str | Path, device: Any = "cpu") -> tuple[dict, Any]:
    """Read the state of a training.

    device: where its tensors go.
    Returns the state and the recipe as `write_state` took them.
    Raises InputError when it is missing, truncated, of another schema or holds anything but plain values.
    """
    import torch

    try:
        value = torch.load(path, map_location=device, weights_only=True)
        if value["schema"] != SCHEMA:
            raise InputError(f"{shown(path)}: expected a training of schema {SCHEMA!r}, found {value['schema']!r}")
        return value["state"], value["recipe"]
    except (FileNotFoundError, IsADirectoryError, PermissionError) as error:
        raise InputError(f"{shown(path)}: cannot be read: {shown(error.strerror or error)}") from error
    except _DAMAGE as error:
        raise InputError(
            f"{shown(path)}: expected the state of a training, found a damaged or other file; --overwrite begins anew"
        ) from error
