"""Quiet start of warp, with a place for its compiled kernels that can be written."""

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock

from caricli.errors import OutputError
from caricli.io.cache import cache_folder

# File descriptors are the process's: were two threads to hold 2 back at once, one would keep what the other put there.
_LOCK = Lock()
_started = False


def start_warp() -> None:
    """Start warp once per process without a word on stdout or stderr; whatever imports it calls this first.

    Threads that call it at once wait for the one that starts it.

    Compiled kernels are kept in WARP_CACHE_PATH where the user set it, else in `caricli/warp` of the user's cache
    (XDG_CACHE_HOME, or ~/.cache); where neither can be written, in a temporary folder that goes with the process.
    """
    global _started
    with _LOCK:
        if _started:
            return
        import warp

        warp.config.log_level = max(warp.config.log_level, warp.LOG_ERROR)
        if warp.config.kernel_cache_dir is None:
            warp.config.kernel_cache_dir = _kernel_folder()
        with _silent_stderr():
            warp.init()
        _started = True


def _kernel_folder() -> str:
    try:
        folder = Path(os.environ.get("WARP_CACHE_PATH") or cache_folder() / "warp")
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return str(folder)
    except (OSError, OutputError):
        passing = tempfile.mkdtemp(prefix="caricli-warp-")
        atexit.register(shutil.rmtree, passing, ignore_errors=True)
        return passing


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Hold back what native code writes to file descriptor 2 (warp warns there when a machine has no GPU)."""
    if sys.stderr is not None:
        sys.stderr.flush()
    try:
        kept = os.dup(2)
    except OSError:  # started without a stderr: nothing to hold back
        yield
        return
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
