"""Networks that come with caricli, or users' own in their place."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from caricli.errors import shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint

Network = TypeVar("Network")


def load_bundled(
    name: str, from_checkpoint: Callable[[dict[str, np.ndarray], dict[str, Any], str], Network], path: Path | None
) -> Network:
    """Load the network of a file, or the bundled one.

    name: file of the latter. from_checkpoint: rebuilds it from tensors, metadata and a name for messages. path: the
    file, or None for the bundled one. Raises InputError when it is no such network, damaged, or not there.
    """
    file = asset_path(name) if path is None else path
    return from_checkpoint(*read_checkpoint(file), shown(file))
