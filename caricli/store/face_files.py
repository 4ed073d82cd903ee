"""The files of a face: its mesh for other tools, and its NPZ for the next command."""

from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from caricli.io.face import write_face
from caricli.io.image import write_png
from caricli.io.meshes.mesh import keeps_texture, write_mesh
from caricli.io.strict_json import write_json
from caricli.io.worn import PictureNames, worn_paths, write_pictures
from caricli.structures import Face, Pictures

if TYPE_CHECKING:
    from caricli.methods.faces.draw_face import FaceDrawing
    from caricli.methods.faces.encode_face import EncodedFace

_ROUNDING = 1e-6
"""Residuals up to this are what single precision loses, and are left out."""


def write_face_result(
    files: Sequence[Path | None],
    face: Face,
    drawing: "FaceDrawing",
    description: dict[str, Any],
    draw: Callable[[], np.ndarray],
) -> None:
    """Write the four files of a face, and beside them the pictures that it wears.

    files: paths of the mesh, whose suffix says its format, the NPZ, the JSON and the PNG, or None for no picture.
    face: Face in its model's own mesh. drawing: FaceDrawing with the finer mesh. description: JSON value.
    draw: makes the picture, (H, W, 3) uint8.
    Raises OutputError when a file cannot be written.
    """
    mesh, npz, json, png = files
    assert mesh is not None and npz is not None and json is not None
    write_face_files(mesh, npz, face, drawing.mesh_face(face))
    write_json(json, description)
    if png is not None:
        write_png(png, draw())


def write_face_files(
    mesh_file: Path, npz_file: Path, face: Face, shown: Face | None = None, names: PictureNames | None = None
) -> PictureNames:
    """Write mesh and NPZ alone, and the pictures of the face.

    mesh_file, npz_file: paths. face: Face. shown: what the mesh file holds of it, in its pictures and perhaps others,
    or None for its own mesh. names: of these pictures, where they are there already.
    Returns the names of the pictures. Raises OutputError.
    """
    shown = shown or face
    # The other formats have no place for pictures; the NPZ keeps them for the next command.
    textured = keeps_texture(mesh_file)
    if names is None:
        names = write_pictures(npz_file, shown.pictures if textured else face.pictures)
    kept = names if textured else PictureNames()
    others = kept.others | shown.pictures.finishes
    write_mesh(mesh_file, shown.mesh, kept.skin, others=others, materials=shown.materials)
    if face.residual is not None and not np.abs(face.residual).max() > _ROUNDING:
        face = replace(face, residual=None)
    own = zip(names, face.pictures, strict=True)
    write_face(npz_file, face, PictureNames(*(None if picture is None else name for name, picture in own)))
    return names


@dataclass(frozen=True)
class FaceSeries:
    """Many faces in a folder: name-000.obj and .npz and so on; and the PNG and JSON of a sheet.

    folder: path. name: that files of faces begin with. count: number of faces. sheet: stem of the sheet's files.
    """

    folder: Path
    name: str
    count: int
    sheet: str

    @property
    def stems(self) -> list[str]:
        """Of the faces' files."""
        return [f"{self.name}-{number:03d}" for number in range(self.count)]

    @property
    def files(self) -> list[Path]:
        """Mesh and NPZ of every face in turn, then the PNG and the JSON of the sheet."""
        names = [f"{stem}{suffix}" for stem in self.stems for suffix in (".obj", ".npz")]
        return [self.folder / name for name in (*names, f"{self.sheet}.png", f"{self.sheet}.json")]

    @property
    def optional(self) -> list[Path]:
        """Files of the pictures that faces may wear."""
        return [path for stem in self.stems for path in worn_paths(self.folder / f"{stem}.obj")]

    def write(
        self,
        files: Sequence[Path],
        faces: "Iterable[tuple[EncodedFace, dict[str, Any]]]",
        drawing: "FaceDrawing",
        drawn: Container[int],
        report: Callable[[int, int], None],
    ) -> tuple[list[dict[str, Any]], list[list[np.ndarray]]]:
        """Write faces as they come.

        files: where, in the order of ``files``. faces: ``count`` pairs of a face and its figures. drawing: FaceDrawing.
        drawn: numbers of the faces to draw. report: called with how many are done, and ``count``.
        Returns the rows of a report, and the views of those that were drawn.
        """
        rows = []
        views = []
        worn: tuple[Pictures, PictureNames] | None = None
        for number, (face, figures) in enumerate(faces):
            # Faces that wear the same share the files.
            shown = drawing.mesh_face(face)
            names = worn[1] if worn and worn[0].same(shown.pictures) else None
            mesh_file, npz_file = files[2 * number : 2 * number + 2]
            names = write_face_files(mesh_file, npz_file, face, shown, names)
            worn = (shown.pictures, names)
            if number in drawn:
                views.append(drawing.draw(face))
            rows.append({"face": self.stems[number]} | figures)
            report(number + 1, self.count)
        return rows, views
