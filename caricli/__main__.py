"""The process `caricli`, and `python -m caricli`, which is the same."""

import ctypes
import gc
import os
import signal
import sys
from contextlib import suppress
from types import FrameType

_CONTAINERS = 200_000
"""New ones after which cycles among them are looked for: the usual 700 cost a tenth of the time of what is imported."""

_ALLOCATION = {-8: 1, -3: 2**25, -1: 2**28}
"""For glibc's mallopt: arenas; bytes from which on a block is the system's own; bytes that are kept when they are free.
"""


def main() -> None:
    """Run caricli as the process: the entry point of the package."""
    # From the first moment: Ctrl-C while the command line itself is imported is no traceback.
    numbers = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) is not signal.SIG_IGN]
    for number in numbers:
        signal.signal(number, _leave)
    _take_closed_streams()
    gc.set_threshold(_CONTAINERS)
    _keep_memory()
    try:
        from caricli.cli import cli

        cli.main()
    finally:
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)  # the outputs are in their places: what comes now comes too late
        gc.freeze()  # the system frees what is left; Python would look for cycles in all of it, for 0.3 s


def _take_closed_streams() -> None:
    """Take the numbers of standard streams that are closed, or the next file that is opened would be printed into.

    What is printed to an output that is closed fails, as on a full disk; a closed stderr takes everything.
    """
    for number, mode in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)  # gets the lowest number that is free
    sys.stdout = sys.stdout or open(1, "w", closefd=False)
    sys.stderr = sys.stderr or open(2, "w", closefd=False)


def _keep_memory() -> None:
    """Let threads use again what others have freed: pages from the system cost more than what most arrays are for.

    A texture takes half as many of them, and a tenth less time. Where there is no glibc, nothing is done.
    """
    with suppress(AttributeError, OSError, TypeError):
        mallopt = ctypes.CDLL(None).mallopt
        for parameter, value in _ALLOCATION.items():
            mallopt(parameter, value)


def _leave(number: int, _: FrameType | None) -> None:
    """End at once: nothing is written yet, and an exception in an extension that is being imported does harm."""
    os.write(2, f"caricli: error: stopped by {signal.Signals(number).name}\n".encode())
    os._exit(128 + number)


if __name__ == "__main__":
    main()
