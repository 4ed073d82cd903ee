"""The files of a face, staged together."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from caricli.commands.shared.options import face_files
from caricli.commands.shared.picture import picture_files
from caricli.commands.shared.progress import progress_bar
from caricli.io.outputs import staged
from caricli.io.worn import worn_paths


@contextmanager
def staged_face(
    out: Path, overwrite: bool, inputs: Iterable[Path | None], doing: str | None = None
) -> Iterator[tuple[Path, Path, Path, Path | None]]:
    """Stage ``face_files``, the last of them None where no picture is wanted, and beside them what the face may wear.

    out, overwrite, inputs: as of ``staged``. doing: what a bar says meanwhile, or None for no bar.
    """
    bar = nullcontext() if doing is None else progress_bar(doing)
    *files, picture = face_files(out)
    wanted = [*files, *picture_files(picture)]
    with staged(*wanted, overwrite=overwrite, inputs=inputs, optional=worn_paths(out)) as staged_files, bar:
        mesh, npz, json, *png = staged_files
        yield mesh, npz, json, png[0] if png else None
