"""The files of a face, staged together."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from caricli.commands.shared.options import face_files
from caricli.commands.shared.progress import progress_bar
from caricli.io.outputs import staged
from caricli.io.worn import worn_paths


@contextmanager
def staged_face(
    out: Path, overwrite: bool, inputs: Iterable[Path | None], doing: str | None = None
) -> Iterator[tuple[Path, ...]]:
    """Stage ``face_files``, and beside them the pictures that the face may wear.

    out, overwrite, inputs: as of ``staged``. doing: what a bar says meanwhile, or None for no bar.
    """
    bar = nullcontext() if doing is None else progress_bar(doing)
    with staged(*face_files(out), overwrite=overwrite, inputs=inputs, optional=worn_paths(out)) as files, bar:
        yield files
