"""The few kinds of failure that a user can meet; each message is one line that says what was expected and what came."""

from collections.abc import Iterator
from contextlib import contextmanager


class CaricliError(Exception):
    """Anything that caricli refuses or fails to do; the command line turns it into one line and exit code 1, or 2."""


class InputError(CaricliError):
    """An input is missing, unreadable, malformed, or does not fit what it is used with."""


class UsageError(InputError):
    """What was typed cannot be meant, whatever the files hold; the command line gives it exit code 2."""


class OutputError(CaricliError):
    """An output cannot be written, exists already, or would replace an input."""


class NumericsError(CaricliError):
    """A computation broke down: a singular system, a solve that is not finite, an impossible fit."""


def shown(value: object, limit: int | None = None) -> str:
    """Return text that stays on one line, characters that do not print escaped.

    value: a path or anything with a text; bytes are read as Latin-1. limit: the longest text kept, characters.
    """
    text = value.decode("latin-1") if isinstance(value, bytes) else str(value)
    if limit is not None and len(text) > limit:
        text = text[:limit] + "..."
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "backslashreplace").decode() for c in text)


@contextmanager
def naming(what: object) -> Iterator[None]:
    """Begin the message of a CaricliError raised inside with what it is about, such as the path of a file, once."""
    try:
        yield
    except CaricliError as error:
        name = f"{shown(what)}: "
        raise type(error)(name + str(error).removeprefix(name)) from error
