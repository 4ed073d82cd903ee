"""The few kinds of failure that a user can meet; each message is one line that says what was expected and what came."""


class CaricliError(Exception):
    """Anything that caricli refuses or fails to do; the command line turns it into one line and exit code 1."""


class InputError(CaricliError):
    """An input is missing, unreadable, malformed, or does not fit what it is used with."""


class OutputError(CaricliError):
    """An output cannot be written, exists already, or would replace an input."""


class NumericsError(CaricliError):
    """A computation broke down: a singular system, a solve that is not finite, an impossible fit."""
