"""What the addresses of one user's studios end in."""

import os
import secrets
import stat
from contextlib import suppress
from html import escape
from pathlib import Path

from caricli.errors import CaricliError
from caricli.io.cache import cache_folder

_LENGTH = 22
"""Characters of 16 bytes."""


def studio_token() -> str:
    """A text that nobody else knows, the same every time, so that a page that is open finds a server that is started
    again.

    It is kept in the user's cache, in a file that others cannot read; where that cannot be, it is another every time.
    """
    fresh = secrets.token_urlsafe(16)
    with suppress(CaricliError, OSError):
        path = cache_folder() / "studio-token"
        kept = _kept(path)
        if kept is not None:
            return kept
        _keep(path, fresh)
    return fresh


def private_link(address: str) -> str:
    """What a browser is to open for an address with a token: others can read the words of its command line.

    It is a page in the user's cache, which nobody else can read and which leads there; where that cannot be, the
    address itself.
    """
    with suppress(CaricliError, OSError):
        path = cache_folder() / "studio.html"
        _keep(path, f'<!doctype html><meta http-equiv="refresh" content="0; url={escape(address)}">\n')
        return path.as_uri()
    return address


def _keep(path: Path, text: str) -> None:
    """Write a file that only this user can read."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileNotFoundError):
        path.unlink()
    descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, stat.S_IRUSR | stat.S_IWUSR)
    with os.fdopen(descriptor, "w", encoding="ascii") as file:
        file.write(text)


def _kept(path: Path) -> str | None:
    """What a file holds that is this user's alone, or None."""
    with suppress(OSError, ValueError):
        status = path.lstat()
        own = stat.S_ISREG(status.st_mode) and status.st_uid == os.getuid()
        if own and not status.st_mode & (stat.S_IRWXG | stat.S_IRWXO):
            text = path.read_text("ascii")
            return text if len(text) == _LENGTH else None
    return None
