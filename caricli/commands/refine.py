"""caricli refine: a face aligned exactly with its picture."""

import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click

from caricli.commands.shared.face_outputs import note_source, staged_face
from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.notes import echo_edited, echo_numbering, echo_result
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    FiniteRange,
    detector_option,
    image_option,
    model_option,
    named_mesh,
    out_option,
    overwrite_option,
    pts_origin_option,
    refuse_unread,
    subdivide_option,
)
from caricli.commands.shared.picture import picture_option, write_picture
from caricli.errors import naming
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.reconstruct.settings import RefineSettings
from caricli.structures import HeadChoice
from caricli.structures.head_choice import WHOLE

SIZE = 384


def _sheet(seen, result, template, head, points, pixels):
    """The picture of a Face before and after its Refinement. head: HeadChoice or None."""
    from caricli.methods.parts.whole_head import whole_head
    from caricli.render.sheets.refine_sheet import refine_sheet

    faces = (seen, result.face)
    heads = [whole_head(face, template, head or WHOLE) for face in faces]
    return refine_sheet(faces, result.anchors, heads, points, pixels, SIZE)


@click.command()
@click.argument("face", type=PATH)
@click.argument("landmarks", type=PATH, metavar="PICTURE|LANDMARKS")
@out_option("REFINED.obj", f"Write the face here, {FACE_FILES}", check=named_mesh)
@image_option
@click.option(
    "--parsing", type=PATH, metavar="MASK.png", help="Snap eye landmarks to the eyes in this label map of the picture."
)
@click.option(
    "--weight",
    type=FiniteRange(1e-4, 1e4),
    default=RefineSettings.weight,
    metavar="W",
    help="Weigh the landmarks against the shape of the surface: larger meets them more exactly.",
)
@click.option(
    "--laplacian",
    type=click.Choice(["cotangent", "uniform"]),
    default=RefineSettings.laplacian,
    help="Let neighbours count by the angles between them (cotangent), or all the same, as published (uniform).",
)
@model_option
@detector_option
@pts_origin_option
@mesh_head_options
@subdivide_option
@picture_option
@overwrite_option
def command(
    face, landmarks, out, image, parsing, weight, laplacian, model, detector, pts_origin, head, levels, overwrite
):
    """Move a face (NPZ with a camera) exactly onto the landmarks of its picture by Laplacian deformation.

    Depth and local shape stay as they are. In a PICTURE the landmarks are found; they are written beside the result,
    REFINED-landmarks.json. Landmarks with spreads are met as far as they are surer than the face. In the picture that
    is written, green circles are the given landmarks and red dots the fitted ones.

    \b
    Example:
      caricli refine face.npz drawing.png --out refined.obj
      caricli refine face.npz landmarks.json --image drawing.png --out refined.obj
      caricli refine face.npz landmarks.json --parsing labels.png --out refined.obj
    """
    refuse_unread([landmarks])
    settings = RefineSettings(weight, laplacian)
    task = RefineTask(image, parsing, settings, model, pts_origin, head, levels, overwrite, detector)
    echo_result(task.run(face, landmarks, out))


@dataclass(frozen=True)
class RefineTask:
    """What is done with a face and its landmarks.

    image: path of the picture; parsing: of its label map; model: of the model of the mesh; each may be None.
    settings: of the deformation. pts_origin: coordinate of the first pixel in .pts files. head: HeadChoice of the mesh,
    or None for the skin. levels: how often its polygons are split. overwrite: whether files that exist are replaced.
    detector: path of what finds landmarks in a picture, or None for the bundled one.
    """

    image: Path | None = None
    parsing: Path | None = None
    settings: RefineSettings = RefineSettings()
    model: Path | None = None
    pts_origin: int = 1
    head: HeadChoice | None = None
    levels: int = 0
    overwrite: bool = False
    detector: Path | None = None

    def run(self, face: Path, landmarks: Path, out: Path) -> str:
        """Move a face onto its landmarks, or those of its picture, write it, and say how near it came."""
        from caricli.methods.parts.whole_head import mesh_face
        from caricli.methods.reconstruct.refine_face import refine_face
        from caricli.methods.reconstruct.snap_eyes import snap_eyes
        from caricli.store.face_files import write_face_files
        from caricli.store.face_pictures import FaceReader, seen_files
        from caricli.store.faces import load_seen_face
        from caricli.store.pictures import load_eyes
        from caricli.template.fine_mesh import fine_mesh

        inputs = (face, landmarks, self.image, self.parsing)
        others = (self.model, self.detector)
        with staged_face(out, self.overwrite, (*inputs, *others), "refining", seen_files(landmarks, out)) as files:
            seen, shape_model = load_seen_face(face, self.model)
            template = shape_model.template
            reader = FaceReader(self.detector, self.pts_origin)
            picture = reader.read(landmarks, len(template.annotation.landmarks), self.image)
            marks = picture.landmarks
            eyes = load_eyes(self.parsing, marks.image_size, marks.points)
            echo_numbering(self.parsing)
            points, snapped = snap_eyes(marks.head_points, eyes)
            echo_edited(face, seen, template, "it goes back onto its picture; refine first, edits keep it")
            start = time.perf_counter()
            with naming(landmarks):
                result = refine_face(seen, points, template, self.settings, marks.spreads)
            seconds = time.perf_counter() - start
            about: dict[str, Any] = {
                "model_id": shape_model.model_id,
                "weight": self.settings.weight,
                "snapped": snapped,
            }
            about |= {"laplacian": self.settings.laplacian, "subdivide": self.levels, "seconds": seconds}
            about |= note_source(files[0], picture, landmarks) | result.figures()
            shown = mesh_face(result.face, template, self.head, fine_mesh(result.face.mesh, self.levels))
            write_face_files(files[0], files[1], result.face_of(shape_model), shown)
            write_json(files[2], provenance("refine", inputs, **about))
            write_picture(files[3], partial(_sheet, seen, result, template, self.head, points, picture.pixels))
        return f"{out}: {result.describe()}"
