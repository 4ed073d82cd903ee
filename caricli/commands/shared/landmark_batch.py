"""What the commands share that fit faces to landmark files: one after the other, each with its own files."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from caricli.commands.shared.batch import named_jobs, run_batch
from caricli.commands.shared.options import face_files
from caricli.io.image import write_png
from caricli.io.mesh import MESH_SUFFIXES
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.faces.subdivide_face import subdivide_face
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.models.shape_model import ShapeModel
from caricli.render.fit_sheet import fit_sheet
from caricli.store.face_files import write_face_files
from caricli.store.pictures import find_picture, load_marked_picture
from caricli.template.fine_mesh import FineMesh


@dataclass(frozen=True)
class LandmarkFiles:
    """What is read and written, as it was typed.

    landmarks: paths. out: of one result; out_dir: folder of many. image: path of the picture, or a folder of them.
    pts_origin: coordinate of the first pixel in .pts files. overwrite: whether files that exist are replaced.
    """

    landmarks: Sequence[Path]
    out: Path | None
    out_dir: Path | None
    image: Path | None
    pts_origin: int
    overwrite: bool

    def __post_init__(self) -> None:
        """Refuse wrong usage before anything is loaded."""
        self.jobs()

    def jobs(self) -> list[tuple[Path, Path]]:
        """Pairs of a landmark file and the mesh to write. Raises click.UsageError where one or many do not fit."""
        return named_jobs(self.landmarks, "LANDMARKS", self.out, self.out_dir, *MESH_SUFFIXES)


@dataclass(frozen=True, eq=False)
class FitTask:
    """What is done with every file.

    command: its name. model: ShapeModel. fine: FineMesh of what is written for other tools. fit: of points (L, 2).
    say: of a fit, what is printed. about: what the JSON says of the run. sources: files that results come from besides.
    """

    command: str
    model: ShapeModel
    fine: FineMesh
    fit: Callable[[np.ndarray], LandmarkFit]
    say: Callable[[LandmarkFit], str]
    about: dict[str, Any]
    sources: Sequence[Path | None] = ()


def fit_all(files: LandmarkFiles, task: FitTask, model: Path | None) -> None:
    """Fit a face to every landmark file, write it and say how near it came. model: path of the task's, if any."""

    def reconstruct(path: Path, target: Path) -> str:
        picture = find_picture(files.image, path, many=files.out is None)
        inputs = (*files.landmarks, model, *task.sources, picture)
        with staged(*face_files(target), overwrite=files.overwrite, inputs=inputs) as temporary:
            marks, pixels = load_marked_picture(path, picture, files.pts_origin)
            start = time.perf_counter()
            fit = task.fit(marks.points)
            seconds = time.perf_counter() - start
            report = provenance(task.command, [path, picture, *task.sources], **task.about)
            finer = subdivide_face(fit.face, task.model, task.fine)
            write_face_files(temporary[0], temporary[1], fit.face, finer)
            write_json(temporary[2], report | fit.figures() | {"seconds": seconds})
            write_png(temporary[3], fit_sheet(fit.face, task.model.template, marks.points, pixels, fine=finer))
        return f"{target}: {task.say(fit)}, {seconds:.2f} s"

    run_batch(click.get_current_context(), files.jobs(), reconstruct, "faces")
