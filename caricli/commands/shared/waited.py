"""How long somebody waited."""

import os
import time
from contextlib import suppress
from pathlib import Path

_imported = time.monotonic()
_asked: list[float] = []


def waited() -> str:
    """Wall time, as text, since the process started, or since this was last asked, as for one item of many.

    It counts all that somebody waits for, the start of Python among it, not only what was computed.
    """
    now = time.monotonic()
    since = _asked[-1] if _asked else now - _age()
    _asked[:] = [now]
    return f"{now - since:.2f} s" if now - since < _ROUND else f"{now - since:.1f} s"


_ROUND = 10  # seconds, from which on a hundredth says nothing


def _age() -> float:
    """Seconds since the process started; where the system does not say, since this was imported."""
    with suppress(OSError, ValueError, IndexError, AttributeError):
        # The name of the program, in brackets, may hold spaces; the start is the 22nd entry of all.
        entries = Path("/proc/self/stat").read_text().rpartition(")")[2].split()
        started = int(entries[19]) / os.sysconf("SC_CLK_TCK")
        return time.clock_gettime(time.CLOCK_BOOTTIME) - started
    return time.monotonic() - _imported
