"""The readers of trimesh, without what they say on the way."""

import io
import logging
import warnings
from collections.abc import Callable
from typing import Any

_SILENT = logging.NullHandler()


def trimesh_load(load: Callable[..., dict[str, Any]], data: bytes, **options: Any) -> dict[str, Any]:
    """What a reader of trimesh makes of bytes. options: of the reader. Raises whatever it raises."""
    # Without a handler what it logs of damaged files goes to stderr.
    logging.getLogger("trimesh").addHandler(_SILENT)
    with warnings.catch_warnings():
        # NumPy's reader of text only warns of words that are no numbers.
        warnings.simplefilter("error", DeprecationWarning)
        return load(io.BytesIO(data), **options)
