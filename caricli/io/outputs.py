"""Outputs that appear whole or not at all: written in a hidden folder beside their place, synced, renamed."""

import errno
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

from caricli import signals
from caricli.errors import CaricliError, OutputError, shown

_PREFIX = ".caricli-"
_REPLACED = ".replaced-"
_STAGING_FOLDER = re.compile(rf"{re.escape(_PREFIX)}[a-z0-9_]{{8}}")  # as tempfile names it; users have others
_WRITE_ERRORS = {
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EROFS,
    errno.EIO,
    errno.EFBIG,
    errno.EACCES,
    errno.EPERM,
    errno.ENAMETOOLONG,
}

_ITEM: ContextVar[tuple[Path, dict[Path, Path]] | None] = ContextVar("item", default=None)


@contextmanager
def written_for(source: Path, writers: dict[Path, Path]) -> Iterator[None]:
    """Let what is staged inside be the outputs of one item of a batch, which replace those of no other item.

    source: the item's input. writers: by output, the input that it was written for; the items of a batch share it.
    """
    token = _ITEM.set((source, writers))
    try:
        yield
    finally:
        _ITEM.reset(token)


@contextmanager
def staged(
    *paths: str | Path,
    overwrite: bool = False,
    inputs: Iterable[Path | None] = (),
    optional: Sequence[Path] = (),
) -> Iterator[tuple[Path, ...]]:
    """Write several files so that either all of them appear or none.

    overwrite: whether existing files are replaced. inputs: files that must not be written to (None entries are
    skipped). optional: outputs that may be written too, under their names beside those that are yielded.
    Yields temporary paths, one per output of ``paths``, each with its output's file name in a hidden folder on the same
    file system.
    On success all are synced and renamed; on any exception, KeyboardInterrupt included, all are removed, and so are the
    parent folders made here that are empty.
    Raises OutputError when an output exists without `overwrite`, is an input, is given twice, is that of another item
    of the batch, or cannot be written.
    """
    required = len(paths)
    paths = (*paths, *optional)
    finals = _finals(paths, overwrite, inputs)
    with _write_errors(paths), _staging({final.parent for final in finals}) as folders:
        temporaries = tuple(folders[final.parent] / final.name for final in finals)
        yield temporaries[:required]
        rows = [(temporary, *names) for temporary, names in zip(temporaries, finals.items(), strict=True)]
        written = rows[:required] + [row for row in rows[required:] if row[0].is_file()]
        for temporary, _, path in written:
            if not temporary.is_file():
                raise OutputError(f"{shown(path)}: nothing was written")
            _sync(temporary)
        _publish(written, overwrite)


@contextmanager
def staged_folder(
    path: str | Path, overwrite: bool = False, inputs: Iterable[Path | None] = (), marker: str | None = None
) -> Iterator[Path]:
    """Write a folder so that it appears with all its content or not at all.

    overwrite: whether an existing folder is replaced as a whole. inputs: files and folders that must not be written to.
    marker: the name of a file that an existing folder must hold to be replaced, so that a mistyped path never deletes
    someone's own files (an empty folder is always replaceable).
    Yields a temporary folder, renamed on success and removed on any exception.
    Raises OutputError as `staged` does, and when the folder to replace holds an input or the current folder.
    """
    final = _checked_folder(path, overwrite, _Inputs.of(inputs), marker)
    with _write_errors([path]), _staging({final.parent}) as folders:
        temporary = folders[final.parent] / final.name
        temporary.mkdir()
        yield temporary
        for folder, _, names in os.walk(temporary):
            for name in names:
                _sync(Path(folder) / name)
            _sync_folder(Path(folder))
        _publish([(temporary, final, path)], overwrite)


def check_outputs(*paths: str | Path, overwrite: bool = False, inputs: Iterable[Path | None] = ()) -> None:
    """Refuse at once what ``staged`` would refuse, folders that cannot be written among it, before work that is long.

    Leaves nothing behind. Raises OutputError.
    """
    for final in _finals(paths, overwrite, inputs):
        check_folder(final.parent)


def check_output_folder(
    path: str | Path, overwrite: bool = False, inputs: Iterable[Path | None] = (), marker: str | None = None
) -> None:
    """Refuse at once what ``staged_folder`` would refuse, before work that is long. Raises OutputError."""
    check_folder(_checked_folder(path, overwrite, _Inputs.of(inputs), marker).parent)


def check_folder(path: str | Path) -> None:
    """Refuse at once a folder into which nothing can be written, or which cannot be made, before work that is long.

    Leaves nothing behind. Raises OutputError.
    """
    with _staging({Path(os.path.realpath(path))}):
        pass


def staging_folders(folder: Path, names: Iterable[str]) -> list[Path]:
    """Hidden folders in a folder in which files of some of these names are being written, or were by who was killed.

    Those in which nothing is yet are left out: what they are for cannot be told.
    """
    possible = set(names)
    folders = []
    for path in filter(lambda path: _STAGING_FOLDER.fullmatch(path.name), folder.glob(f"{_PREFIX}*")):
        with suppress(OSError):  # it may just have gone
            inside = os.listdir(path)
            if inside and all(name in possible or name.startswith(_REPLACED) for name in inside):
                folders.append(path)
    return folders


@contextmanager
def writing(path: str | Path) -> Iterator[None]:
    """Turn the operating system's refusal to write into an OutputError.

    path: the file being written; when it is a temporary path of `staged` the message names the output.
    Raises OutputError for any OSError raised inside.
    """
    try:
        yield
    except OSError as error:
        raise OutputError(f"{shown(final_name(path))}: cannot be written: {_reason(error)}") from error


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write bytes to a file.

    Raises OutputError when it cannot be written.
    """
    with writing(path), open(path, "wb") as stream:
        stream.write(data)


def _reason(error: OSError) -> str:
    return shown(error.strerror or error)


def final_name(path: str | Path) -> Path:
    """The path itself, or that of the output that a temporary path of ``staged`` becomes."""
    return Path(*(part for part in Path(path).parts if not _STAGING_FOLDER.fullmatch(part)))


@contextmanager
def _write_errors(paths: Sequence[str | Path]) -> Iterator[None]:
    """Turn refusals of the operating system into OutputErrors, and let messages name outputs where they will stand."""
    try:
        yield
    except OSError as error:
        named = isinstance(error.filename, str | os.PathLike) and bool(_STAGING_FOLDER.search(str(error.filename)))
        if not named and error.errno not in _WRITE_ERRORS:
            raise
        name = final_name(str(error.filename)) if named else paths[0]
        raise OutputError(f"{shown(name)}: cannot be written: {_reason(error)}") from error
    except CaricliError as error:
        if not _STAGING_FOLDER.search(str(error)):
            raise
        raise type(error)(re.sub(_STAGING_FOLDER.pattern + "/", "", str(error))) from error


@dataclass(frozen=True)
class _Inputs:
    """What must not be written to, looked up once for many outputs.

    places: where the paths lead, each with the path itself. files: device and inode of what is there, which all names
    of a file share.
    """

    places: dict[Path, Path]
    files: set[tuple[int, int]]

    @staticmethod
    def of(paths: Iterable[Path | None]) -> "_Inputs":
        places = {_place(path): path for path in paths if path is not None}
        identities = map(_identity, places)
        return _Inputs(places, {identity for identity in identities if identity is not None})

    def hold(self, final: Path) -> bool:
        return final in self.places or _identity(final) in self.files


def _place(path: str | Path) -> Path:
    """Where a path leads."""
    try:
        with writing(path):
            return Path(os.path.realpath(path))
    except ValueError as error:
        raise OutputError(f"{shown(path)}: expected a path, found {shown(error)}") from error


def _identity(place: Path) -> tuple[int, int] | None:
    """Device and inode, or None where nothing is."""
    try:
        status = os.stat(place)
    except OSError:
        return None
    return status.st_dev, status.st_ino


def _resolved(path: str | Path, inputs: _Inputs, asked: str | Path | None = None) -> Path:
    """Where a path leads, which must be no input. asked: the output that this one goes beside, or None."""
    final = _place(path)
    if inputs.hold(final):
        follows = asked is not None and path != asked and Path(path).name.startswith(Path(asked).stem)
        beside = f"; it goes beside {shown(asked)}: give that another name" if follows else ""
        raise OutputError(f"{shown(path)}: expected an output, found one of the inputs{beside}")
    _check_item(path, final)
    return final


def _check_item(path: str | Path, final: Path) -> None:
    """Refuse what another item of the batch wrote."""
    item = _ITEM.get()
    if item is None:
        return
    source, writers = item
    writer = writers.get(final, source)
    if writer != source:
        raise OutputError(f"{shown(path)}: expected an output of its own, found what was written for {shown(writer)}")


def _finals(paths: Sequence[str | Path], overwrite: bool, inputs: Iterable[Path | None]) -> dict[Path, str | Path]:
    """Where outputs lead, each with its path. Raises OutputError as ``staged`` before anything is written."""
    sources = _Inputs.of(inputs)
    finals: dict[Path, str | Path] = {}
    for path in paths:
        final = _checked_file(path, overwrite, sources, paths[0])
        if final in finals:
            raise OutputError(f"{shown(path)}: expected different outputs, found the same one twice")
        finals[final] = path
    return finals


def _is_there(final: Path) -> bool:
    """Whether something stands in the place, be it a link that leads to itself, which ``exists`` does not see."""
    return final.exists() or final.is_symlink()


def _checked_file(path: str | Path, overwrite: bool, inputs: _Inputs, asked: str | Path | None = None) -> Path:
    final = _resolved(path, inputs, asked)
    with writing(path):
        if _is_there(final):
            if not final.is_file():
                other = "a folder" if final.is_dir() else "something that is not a regular file"
                raise OutputError(f"{shown(path)}: expected a file to write, found {other}")
            if not overwrite:
                raise OutputError(f"{shown(path)} exists; give --overwrite to replace it")
    return final


def _checked_folder(path: str | Path, overwrite: bool, inputs: _Inputs, marker: str | None) -> Path:
    final = _resolved(path, inputs)
    with writing(path):
        if not _is_there(final):
            return final
        if not final.is_dir():
            raise OutputError(f"{shown(path)}: expected a folder to write, found a file")
        if not overwrite:
            raise OutputError(f"{shown(path)} exists; give --overwrite to replace it")
        if Path.cwd().is_relative_to(final) or final == Path(os.path.realpath(os.path.expanduser("~"))):
            raise OutputError(f"{shown(path)}: expected a folder to replace, found the current or the home folder")
        for place, source in inputs.places.items():
            if place.is_relative_to(final):
                held = f"a folder that holds the input {shown(source)}"
                raise OutputError(f"{shown(path)}: expected an output, found {held}")
        if marker is not None and not (final / marker).is_file() and any(final.iterdir()):
            raise OutputError(f"{shown(path)}: expected a folder with {marker} to replace, found other files")
    return final


@contextmanager
def _staging(parents: set[Path]) -> Iterator[dict[Path, Path]]:
    """Hidden folders in the parents, which are made where they are not there; all goes away at the end."""
    created: list[Path] = []
    folders: dict[Path, Path] = {}
    try:
        for parent in sorted(parents):
            with signals.held():
                for folder in reversed([parent, *parent.parents]):
                    if not folder.is_dir():
                        with writing(folder):
                            folder.mkdir()
                        created.append(folder)
                with writing(parent):
                    folders[parent] = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=parent))
        yield folders
    finally:
        with signals.held():
            for folder in folders.values():
                shutil.rmtree(folder, ignore_errors=True)
            for folder in reversed(created):
                # After success the folder holds an output, and rmdir leaves it alone.
                with suppress(OSError):
                    folder.rmdir()


def _publish(files: Sequence[tuple[Path, Path, str | Path]], overwrite: bool) -> None:
    """Give finished files their places; what fails or is stopped half way is taken back.

    files: of each where it is, where it goes, and what it was called.
    """
    moved: list[tuple[Path, Path, Path | None]] = []
    with signals.held():
        try:
            for temporary, final, path in files:
                if _is_there(final) and not overwrite:
                    raise OutputError(f"{shown(path)} exists; give --overwrite to replace it")
                backup = _keep(final, temporary.with_name(f"{_REPLACED}{len(moved)}"))
                moved.append((temporary, final, backup))
                os.replace(temporary, final)
            signals.raise_if_asked()
        except BaseException:
            for temporary, final, backup in reversed(moved):
                if not temporary.exists():
                    os.replace(final, temporary)
                if backup is not None:
                    os.replace(backup, final)
            raise
    item = _ITEM.get()
    if item is not None:
        source, writers = item
        writers.update({final: source for _, final, _ in files})
    for parent in {final.parent for _, final, _ in files}:
        _sync_folder(parent)


def _keep(final: Path, backup: Path) -> Path | None:
    """Keep what stands in an output's place under another name; None when nothing does."""
    if not _is_there(final):
        return None
    try:
        # A second name keeps the old file in its place until the new one replaces it.
        os.link(final, backup)
    except OSError:
        os.replace(final, backup)
    return backup


def _sync(path: str | Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _sync_folder(path: str | Path) -> None:
    # Some file systems cannot sync a folder; the files themselves are synced by then.
    with suppress(OSError):
        _sync(path)
