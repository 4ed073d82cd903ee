"""Arrays that take long to make and always come out the same, kept in the user's cache."""

import contextlib
import hashlib
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from threading import RLock

import numpy as np
import scipy
from threadpoolctl import threadpool_limits

from caricli.errors import CaricliError
from caricli.io.cache import cache_folder
from caricli.io.npz import read_npz, write_npz
from caricli.io.outputs import staged

MOST = 128 * 2**20
"""Bytes of all files: of the bundled heads and of some own ones. What was not asked for for the longest time goes."""

QUICK = 0.02
"""Seconds: what is made sooner, as of small meshes, is not kept."""

_PACKAGE = Path(__file__).parent.parent
_alone = RLock()


def kept_arrays(
    name: str, given: Iterable[np.ndarray | str | float], make: Callable[[], Mapping[str, np.ndarray]]
) -> Mapping[str, np.ndarray]:
    """What ``make`` gives, or gave before: the same arrays, from the folder ``kept`` of the user's cache.

    name: of the files. given: all that the result depends on besides this very program; what another version of it
    made, or one that was changed since, does not count. make: called where nothing is kept. A file that is damaged is
    made again; one that cannot be written only costs time.
    """
    path = _kept_path(name, given)
    if path is not None:
        with contextlib.suppress(CaricliError):
            kept = read_npz(path)
            with contextlib.suppress(OSError):  # in a cache that can only be read
                os.utime(path)
            return kept
    start = time.perf_counter()
    # Sums of several threads come out otherwise, by a last bit that all later results would keep. The limit is that of
    # the whole process: one that was set beside another would stay, or end too soon.
    with _alone, threadpool_limits(limits=1):
        arrays = make()
    if path is not None and time.perf_counter() - start > QUICK:
        _keep(path, arrays)
    return arrays


def _keep(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    with contextlib.suppress(CaricliError, OSError):
        with staged(path, overwrite=True) as (temporary,):
            write_npz(temporary, arrays, packed=False)
        files = sorted((file.stat().st_mtime_ns, file.stat().st_size, file) for file in path.parent.glob("*.npz"))
        total = sum(size for _, size, _ in files)
        for _, size, file in files:
            if total > MOST:
                file.unlink()
                total -= size


def _kept_path(name: str, given: Iterable[np.ndarray | str | float]) -> Path | None:
    digest = hashlib.sha256(_program().encode())
    for value in given:
        array = np.ascontiguousarray(value)
        digest.update(f"{array.dtype}{array.shape}".encode())
        digest.update(array.tobytes())
    with contextlib.suppress(CaricliError):
        return cache_folder() / "kept" / f"{name}-{digest.hexdigest()[:32]}.npz"
    return None


@cache
def _program() -> str:
    """What tells this program from another version of it: its files, and the libraries that compute."""
    files = sorted(f"{path} {status.st_size} {status.st_mtime_ns}" for path, status in _sources(_PACKAGE))
    return "\n".join([np.__version__, scipy.__version__, *files])


def _sources(folder: str | Path) -> Iterator[tuple[str, os.stat_result]]:
    """The Python files of a folder and those below it, with their sizes and times."""
    for entry in os.scandir(folder):
        if entry.is_dir():
            yield from _sources(entry.path)
        elif entry.name.endswith(".py"):
            yield entry.path, entry.stat()
