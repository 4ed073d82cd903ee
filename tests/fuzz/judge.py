"""What a reader may do with any file: read it, or refuse it in one line, quietly, soon and without much memory."""

import contextlib
import os
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

from caricli.errors import CaricliError

MAX_BYTES = 2**30
"""Memory that a reader may ask for beyond what there is."""

MAX_SECONDS = 5.0
"""Of the processor."""


REPORT = ".report.txt"
"""End of the names of files that say what a file led to, beside that file."""


def judged(read: Callable[[Path], object], path: Path) -> str | None:
    """Give a file to a reader. Returns what it did that it may not do, the first line a summary, or None."""
    start = time.process_time()
    with _caught_output() as output, _little_memory(), warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        problem = _outcome(read, path)
    seconds = time.process_time() - start
    if problem is None and warned:
        problem = f"warned: {warned[0].category.__name__}: {warned[0].message}"
    if problem is None and output:
        problem = f"wrote to stderr: {output[0]}"
    if problem is None and seconds > MAX_SECONDS:
        problem = f"took {seconds:.1f} s"
    return problem


def _outcome(read: Callable[[Path], object], path: Path) -> str | None:
    try:
        read(path)
    except CaricliError as error:
        return None if str(error).isprintable() else f"a message of several lines: {error!r}"
    except Exception as error:
        inside = [
            frame for frame in traceback.extract_tb(error.__traceback__) if f"{os.sep}caricli{os.sep}" in frame.filename
        ]
        where = f"{Path(inside[-1].filename).name}:{inside[-1].name}" if inside else "elsewhere"
        return f"{type(error).__name__} in {where}\n{''.join(traceback.format_exception(error))}"
    return None


@contextlib.contextmanager
def _caught_output() -> Iterator[list[str]]:
    """Everything that is written to stdout and stderr, libraries' own included."""
    output: list[str] = []
    with tempfile.TemporaryFile() as stream:
        kept = os.dup(1), os.dup(2)
        _flush()
        for number in (1, 2):
            os.dup2(stream.fileno(), number)
        try:
            yield output
        finally:
            _flush()
            for number, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, number)
                os.close(copy)
            stream.seek(0)
            text = stream.read(2000).decode("utf-8", "replace")
            output += [text] if text else []


def _flush() -> None:
    sys.stdout.flush()
    sys.stderr.flush()


@contextlib.contextmanager
def _little_memory() -> Iterator[None]:
    pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MAX_BYTES, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
