"""What the commands share that fit faces to landmark files: one after the other, each with its own files."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from caricli.commands.shared.batch import named_jobs
from caricli.commands.shared.face_outputs import note_source, staged_face
from caricli.commands.shared.notes import echo_numbering
from caricli.commands.shared.picture import write_picture
from caricli.errors import UsageError, naming
from caricli.io.image import is_image_file
from caricli.io.meshes.mesh import MESH_SUFFIXES
from caricli.io.parsing import is_legend
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.subdivide_face import finer_face, subdivide_face
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.models.shape_model import ShapeModel
from caricli.store.face_files import write_face_files
from caricli.store.face_pictures import FaceReader, seen_files
from caricli.store.pictures import find_picture, load_regions
from caricli.structures import Face, HeadChoice
from caricli.structures.detection import FacePicture
from caricli.structures.head_choice import WHOLE
from caricli.template.fine_mesh import FineMesh, fine_mesh


@dataclass(frozen=True)
class LandmarkFiles:
    """What is read and written, as it was typed.

    landmarks: paths of them, or of pictures. out: of one result; out_dir: folder of many. image: path of the picture of
    landmarks, or a folder of them. reader: FaceReader of the paths. overwrite: whether files that exist are replaced.
    parsing: path of the label map of one picture, or None to let the detector see what pictures show.
    """

    landmarks: Sequence[Path]
    out: Path | None
    out_dir: Path | None
    image: Path | None
    reader: FaceReader
    overwrite: bool
    parsing: Path | None = None

    def __post_init__(self) -> None:
        """Refuse wrong usage before anything is loaded."""
        self.jobs()
        if self.parsing is not None and (self.out is None or self.image is None or is_image_file(self.landmarks[0])):
            raise UsageError("--parsing is of the --image of one landmark file; without it the detector looks")

    def jobs(self) -> list[tuple[Path, Path]]:
        """Pairs of a landmark file and the mesh to write. Raises click.UsageError where one or many do not fit.

        Of many files the legends of label maps are left out: ``detect`` writes them beside landmarks, as JSON, too.
        """
        marks = self.landmarks
        if len(marks) > 1:
            marks = [path for path in marks if not is_legend(path)] or marks
        return named_jobs(marks, "PICTURE|LANDMARKS", self.out, self.out_dir, *MESH_SUFFIXES)


@dataclass(frozen=True, eq=False)
class FitTask:
    """What is done with every file.

    command: its name. files: what is read and written. model: ShapeModel. levels: how often the polygons of what is
    written for other tools are split. fit: of a FacePicture, with what it shows where the fit ``parses``. about: what
    the JSON says of the run. inputs: files that the model is from; sources: others that results come from. worn: Face
    whose pictures the results wear, or None. head: HeadChoice, or None, as of FaceDrawing. latents: ShapeModel of the
    same mesh, whose latent results get instead of that of ``model``, or None.
    """

    command: str
    files: LandmarkFiles
    model: ShapeModel
    levels: int
    fit: Callable[..., LandmarkFit]
    about: dict[str, Any]
    inputs: Sequence[Path | None] = ()
    sources: Sequence[Path | None] = ()
    worn: Face | None = None
    head: HeadChoice | None = None
    latents: ShapeModel | None = None
    parses: bool = False

    @cached_property
    def fine(self) -> FineMesh:
        """The finer mesh of the model's template."""
        return fine_mesh(self.model.template, self.levels)

    def run(self, path: Path, target: Path) -> str:
        """Fit a face to a landmark file, write it, and say how near it came."""
        image = find_picture(self.files.image, path, None if self.files.out else target.stem)
        labels = self.files.parsing if self.parses else None
        inputs = (*self.files.landmarks, *self.inputs, *self.sources, image, labels, self.files.reader.path)
        with staged_face(target, self.files.overwrite, inputs, optional=seen_files(path, target)) as files:
            picture = self._read(path, image, labels)
            start = time.perf_counter()
            with naming(path):
                fit = self.fit(picture)
            seconds = time.perf_counter() - start
            face = fit.face if self.worn is None else fit.face.wearing(self.worn)
            finer = subdivide_face(face, self.model, self.fine)
            if self.latents is not None:
                face = encode_face(face, self.latents)
            mesh, npz, json, png = files
            write_face_files(mesh, npz, face, self._shown(face, finer))
            about = self.about | {"latent_model_id": face.model_id, "subdivide": self.levels}
            about |= note_source(mesh, picture, path)
            report = provenance(self.command, [path, image, labels, *self.sources], **about)
            write_json(json, report | fit.figures() | {"seconds": seconds})
            points = fit.shown(picture.landmarks.head_points)
            write_picture(png, partial(self._sheet, face, finer, points, picture.pixels))
        return f"{target}: {fit.describe()}"

    def _read(self, path: Path, image: Path | None, labels: Path | None) -> FacePicture:
        """Landmarks and their picture, or the picture at path itself, with what it shows where that is asked for."""
        picture = self.files.reader.read(path, len(self.model.template.annotation.landmarks), image)
        if not self.parses or picture.pixels is None or picture.seen is not None:
            return picture
        if labels is not None:
            size = (picture.pixels.shape[1], picture.pixels.shape[0])
            regions = load_regions(labels, size, picture.landmarks.points)
            echo_numbering(labels)
            return replace(picture, regions=regions)
        return replace(picture, regions=self.files.reader.given(picture.pixels, picture.landmarks.points).regions)

    def _shown(self, face: Face, finer: FineMesh) -> Face:
        """What the mesh file holds of a face: its skin, or the head that was chosen."""
        if self.head is None:
            return finer_face(face, finer)
        from caricli.methods.parts.whole_head import mesh_face

        return mesh_face(face, self.model.template, self.head, finer)

    def _sheet(self, face: Face, finer: FineMesh, points: np.ndarray, pixels: np.ndarray | None) -> np.ndarray:
        """The picture of a face and the landmarks (L, 2) that it was fitted to."""
        # What draws takes a while to start.
        from caricli.methods.parts.whole_head import whole_head
        from caricli.render.sheets.fit_sheet import fit_sheet

        return fit_sheet(face, whole_head(face, self.model.template, self.head or WHOLE), points, pixels, fine=finer)
