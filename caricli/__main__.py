"""The process `caricli`, and `python -m caricli`, which is the same."""

import os
import signal
from types import FrameType


def main() -> None:
    """Run caricli as the process: the entry point of the package."""
    # From the first moment: Ctrl-C while the command line itself is imported is no traceback.
    numbers = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) is not signal.SIG_IGN]
    for number in numbers:
        signal.signal(number, _leave)
    try:
        from caricli.cli import cli

        cli.main()
    finally:
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)  # the outputs are in their places: what comes now comes too late


def _leave(number: int, _: FrameType | None) -> None:
    """End at once: nothing is written yet, and an exception in an extension that is being imported does harm."""
    os.write(2, f"caricli: error: stopped by {signal.Signals(number).name}\n".encode())
    os._exit(128 + number)


if __name__ == "__main__":
    main()
