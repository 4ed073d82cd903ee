"""The files of a face: its mesh for other tools, and its NPZ for the next command."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from caricli.io.face import write_face
from caricli.io.mesh import write_mesh
from caricli.methods.faces.subdivide_face import subdivide_face
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face
from caricli.template.fine_mesh import FineMesh

_ROUNDING = 1e-6
"""Residuals up to this are what single precision loses, and are left out."""


def write_face_files(mesh_file: Path, npz_file: Path, face: Face, finer: FineMesh) -> None:
    """Write the mesh of a face, in the format of its suffix, and its NPZ.

    face: Face in its model's own mesh. finer: FineMesh in the shape of the face.
    Raises OutputError when a file cannot be written.
    """
    write_mesh(mesh_file, finer.mesh)
    if face.residual is not None and not np.abs(face.residual).max() > _ROUNDING:
        face = replace(face, residual=None)
    write_face(npz_file, face)


def series_files(folder: Path, name: str, count: int, sheet: str) -> list[Path]:
    """Files of many faces: OBJ and NPZ of each in turn, named name-000 and so on; then PNG and JSON of a sheet."""
    faces = [folder / f"{name}-{number:03d}{suffix}" for number in range(count) for suffix in (".obj", ".npz")]
    return [*faces, folder / f"{sheet}.png", folder / f"{sheet}.json"]
