"""The user's cache folder."""

import os
from pathlib import Path

from caricli.errors import OutputError


def cache_folder() -> Path:
    """Where caricli keeps what it can make again: ``caricli`` in XDG_CACHE_HOME, else in ``~/.cache``.

    A relative XDG_CACHE_HOME does not count, as the XDG base directory specification says. The folder need not exist.
    Raises OutputError when there is no home folder either.
    """
    cache_home = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(cache_home):
        return Path(cache_home) / "caricli"
    try:
        return Path.home() / ".cache" / "caricli"
    except RuntimeError:  # no HOME, and a user without an entry in the system's list
        raise OutputError("expected a home folder or XDG_CACHE_HOME for the cache, found neither") from None
