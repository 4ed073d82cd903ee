"""What a training needs to go on: tensors and counters in one file, loaded without running code."""

import io
import warnings
import zipfile
from pathlib import Path
from typing import Any

from caricli.errors import InputError, naming, shown
from caricli.io.files import read_bytes
from caricli.io.outputs import staged, writing
from caricli.limits import MAX_CHECKPOINT_BYTES

SCHEMA = "caricli.training/1"
_KIND = "the state of a training"


def write_state(path: str | Path, state: dict, recipe: Any) -> None:
    """Replace the state of a training at once: killed while it writes, the one before stays.

    state: tensors, numbers, lists and dicts by name. recipe: JSON value, what is being trained.
    Raises OutputError when it cannot be written.
    """
    import torch

    with staged(path, overwrite=True) as (temporary,), writing(temporary), open(temporary, "wb") as stream:
        torch.save({"schema": SCHEMA, "recipe": recipe, "state": state}, stream)


def read_state(path: str | Path) -> tuple[dict, Any]:
    """Read the state of a training.

    Returns the state and the recipe as `write_state` took them.
    Raises InputError when it is missing, truncated, of another schema or holds anything but plain values.
    """
    data = read_bytes(path, MAX_CHECKPOINT_BYTES, _KIND)
    with naming(path):
        value = _load(data)
        schema = value.get("schema") if isinstance(value, dict) else None
        if schema != SCHEMA:
            raise InputError(f"expected a training of schema {SCHEMA!r}, found {shown(schema, 60)!r}")
        for key in ("state", "recipe"):
            if not isinstance(value.get(key), dict):
                raise InputError(f"expected a training with its {key}, found none")
        return value["state"], value["recipe"]


def _load(data: bytes) -> Any:
    """What torch saved; not what its older versions did, without a zip archive around it."""
    import torch

    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            # torch stores as it is; what is packed could expand without end.
            sound = all(member.compress_type == zipfile.ZIP_STORED for member in archive.infolist())
        if not sound:
            raise ValueError("packed members")
        # What is strange about a damaged file is said once, by the error.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)
    except Exception as error:  # both raise whatever they meet
        raise InputError(f"expected {_KIND}, found a damaged or other file") from error
