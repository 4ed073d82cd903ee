"""The files of a face, staged together."""

from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path

from caricli.commands.shared.options import face_files
from caricli.io.outputs import staged
from caricli.io.worn import worn_paths


def staged_face(out: Path, overwrite: bool, inputs: Iterable[Path | None]) -> AbstractContextManager[tuple[Path, ...]]:
    """Stage ``face_files``, and beside them the pictures that the face may wear; arguments as of ``staged``."""
    return staged(*face_files(out), overwrite=overwrite, inputs=inputs, optional=worn_paths(out))
