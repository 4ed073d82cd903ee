"""The files of a face, staged together."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

from caricli.commands.shared.notes import echo_notes
from caricli.commands.shared.picture import picture_files
from caricli.commands.shared.progress import progress_bar
from caricli.io.outputs import staged
from caricli.io.worn import worn_paths
from caricli.store.face_pictures import write_seen_landmarks
from caricli.structures.detection import FacePicture


def note_source(out: Path, picture: FacePicture | None, source: Path) -> dict[str, Any]:
    """Write the landmarks that were found in a picture beside a file, say what is worth knowing of them on stderr, and
    return what reports say of them, as JSON.

    out: file of the result. picture: FacePicture of the path source, or None where there is none.
    """
    if picture is None:
        return {}
    write_seen_landmarks(out, picture)
    echo_notes(picture.note(source))
    return picture.figures()


def face_files(path: Path) -> list[Path]:
    """The files of a face, of one stem: its mesh with the suffix that was typed, NPZ, JSON, and where a picture is
    wanted PNG.
    """
    return [path, path.with_suffix(".npz"), path.with_suffix(".json"), *picture_files(path.with_suffix(".png"))]


@contextmanager
def staged_face(
    out: Path, overwrite: bool, inputs: Iterable[Path | None], doing: str | None = None, optional: Sequence[Path] = ()
) -> Iterator[tuple[Path, Path, Path, Path | None]]:
    """Stage ``face_files``, the last of them None where no picture is wanted, and beside them what the face may wear.

    out, overwrite, inputs: as of ``staged``. doing: what a bar says meanwhile, or None for no bar.
    optional: further files that may go beside it.
    """
    bar = nullcontext() if doing is None else progress_bar(doing)
    with (
        staged(
            *face_files(out), overwrite=overwrite, inputs=inputs, optional=[*worn_paths(out), *optional]
        ) as staged_files,
        bar,
    ):
        mesh, npz, json, *png = staged_files
        yield mesh, npz, json, png[0] if png else None
