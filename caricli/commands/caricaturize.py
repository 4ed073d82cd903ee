"""caricli caricaturize: regular faces made caricatures."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from caricli.commands.shared.face_outputs import staged_face
from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.notes import echo_notes
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    FiniteRange,
    directions_option,
    image_option,
    model_option,
    out_folder_option,
    out_option,
    overwrite_option,
    pts_origin_option,
    refuse_typed,
    subdivide_option,
)
from caricli.commands.shared.picture import SIZE, picture_option
from caricli.io.provenance import provenance
from caricli.methods.edit.settings import MODES
from caricli.structures import Directions

if TYPE_CHECKING:
    from caricli.methods.faces.draw_face import FaceDrawing
    from caricli.store.regular_faces import FaceLoader

DRAWN = (0.0, 0.5, 1.0)
"""Shares of the strength that the picture shows."""


@click.command()
@click.argument("faces", nargs=-1, required=True, type=PATH, metavar="FACE...")
@click.option(
    "--strength",
    type=FiniteRange(0, 10),
    default=1.0,
    metavar="S",
    help="Exaggerate so much: 0 changes nothing, 1 shows clearly, 2 is strong.",
)
@click.option(
    "--mode",
    type=click.Choice(MODES),
    default="direction",
    help="Go towards what caricatures have in common (direction), or away from the mean head (own).",
)
@out_option("FACE.obj", f"Write the face of one input here, {FACE_FILES}", required=False)
@out_folder_option("Write the faces of many inputs into this folder, each under the name of its input.")
@click.option("--from-landmarks", "marked", is_flag=True, help="Reconstruct FACE, which is a landmark file, first.")
@image_option
@pts_origin_option
@directions_option
@model_option
@mesh_head_options
@subdivide_option
@picture_option
@overwrite_option
@click.pass_context
def command(
    ctx, faces, strength, mode, out, out_dir, marked, image, pts_origin, directions, model, head, levels, overwrite
):
    """Exaggerate faces (NPZ, OBJ, PLY, GLB or glTF), or with --from-landmarks the faces that landmarks belong to.

    The direction goes from regular faces to caricatures, the same way for all; a face's own way enlarges whatever sets
    it apart. The picture shows strengths up to the one asked for.

    \b
    Example:
      caricli caricaturize face.npz --strength 2 --out caricature.obj
      caricli caricaturize faces/*.npz --mode own --out-dir caricatures
      caricli caricaturize landmarks.json --from-landmarks --image photo.jpg --out caricature.obj
    """
    from caricli.commands.shared.batch import named_jobs, run_batch
    from caricli.io.meshes.mesh import MESH_SUFFIXES
    from caricli.store.directions import directions_path, load_directions
    from caricli.store.drawings import load_drawing
    from caricli.store.regular_faces import face_loader, landmark_loader

    if not marked:
        refuse_typed("--image and --pts-origin go with --from-landmarks.", "image", "pts_origin")
    jobs = named_jobs(faces, "LANDMARKS" if marked else "FACE", out, out_dir, *MESH_SUFFIXES)
    drawing = load_drawing(model, levels, SIZE, head)
    # A face's own way needs no directions, so it works for models that have none.
    path = directions_path(directions, drawing.model) if directions or mode == "direction" else None
    labels = None if path is None else load_directions(drawing.model, path)
    anew = model is None
    load = landmark_loader(drawing.model, pts_origin, SIZE) if marked else face_loader(drawing.model, anew)
    about = {"model_id": drawing.model.model_id, "mode": mode, "strength": strength, "subdivide": levels}
    task = _Task(drawing, load, labels, about, path, image, out is None, (*faces, model, path), overwrite)
    run_batch(ctx, jobs, task.run, "faces")


@dataclass(frozen=True, eq=False)
class _Task:
    """What is done with every face.

    drawing: FaceDrawing of the model. load: FaceLoader. labels: Directions, or None. about: of the run, for the JSON.
    path: of the directions, or None. image: path of the picture, or where many is set of a folder of pictures, or None.
    inputs: paths that are read. overwrite: whether files that exist are replaced.
    """

    drawing: "FaceDrawing"
    load: "FaceLoader"
    labels: Directions | None
    about: dict[str, Any]
    path: Path | None
    image: Path | None
    many: bool
    inputs: tuple[Path | None, ...]
    overwrite: bool

    def run(self, source: Path, target: Path) -> str:
        """Caricaturize one face, of a file of it or of landmarks. target: of the mesh. Returns the line to print."""
        from caricli.methods.edit.caricature_sheet import caricature_sheet
        from caricli.methods.edit.caricaturize_face import caricature_figures, caricaturize_face
        from caricli.store.face_files import write_face_result
        from caricli.store.pictures import find_picture

        picture = find_picture(self.image, source, target.stem if self.many else None)
        model = self.drawing.model
        strengths = [self.about["strength"] * share for share in DRAWN]
        with staged_face(target, self.overwrite, (*self.inputs, picture)) as files:
            regular = self.load(source, picture)
            degrees = [caricaturize_face(regular.face, model, s, self.about["mode"], self.labels) for s in strengths]
            figures = caricature_figures(regular.face, degrees[-1], model, self.labels)
            description = provenance("caricaturize", [source, picture, self.path], **self.about, **figures)
            draw = partial(caricature_sheet, degrees, strengths, self.drawing, regular.portrait)
            write_face_result(files, degrees[-1], self.drawing, description, draw)
        echo_notes(regular.note)
        return f"{target}: {_summary(figures)}"


def _summary(figures):
    """The line to print: how far from the mean head, how plausible, how sound."""
    before, after = (figures[when]["exaggeration"]["distance"] for when in ("before", "after"))
    prior = figures["after"]["prior_rms"]
    flipped = 100 * figures["after"]["flipped"]
    return f"distance {before:.3f} to {after:.3f}, prior {prior:.2f}, flipped triangles {flipped:.3f} %"
