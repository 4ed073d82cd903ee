"""caricli interpolate: from one face to another."""

import click
import numpy as np

from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    WholeRange,
    model_option,
    out_folder_option,
    overwrite_option,
    subdivide_option,
)
from caricli.io.image import write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

DRAWN = 12
SIZE = 256


@click.command()
@click.argument("first", type=PATH, metavar="A")
@click.argument("second", type=PATH, metavar="B")
@click.option("--steps", type=WholeRange(2, 1000), default=7, metavar="N", help="Make N faces, A and B among them.")
@out_folder_option("Write the faces and their strip into this folder.", required=True)
@model_option
@mesh_head_options
@subdivide_option
@overwrite_option
def command(first, second, steps, out_dir, model, head, levels, overwrite):
    """Go from face A to face B (NPZ, OBJ, PLY, GLB or glTF) in equal steps.

    The steps are step-000.obj and .npz and so on; strip.png shows at most 12 of them, and strip.json has their figures.
    The latents run along a straight line, and so does what they cannot express. A face without a latent is encoded
    first, and without --model also one whose latent is of another bundled model than the default.

    \b
    Example:
      caricli interpolate faces/face-000.npz faces/face-001.npz --steps 9 --out-dir between
      caricli interpolate neutral.obj smile.obj --steps 5 --out-dir smiling --subdivide 1
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.faces.face_figures import soundness
    from caricli.methods.faces.interpolate_faces import interpolate_faces
    from caricli.render.sheets.view_sheets import film_strip
    from caricli.store.drawings import load_drawing
    from caricli.store.face_files import FaceSeries
    from caricli.store.faces import load_latent_face

    drawing = load_drawing(model, levels, SIZE, head)
    series = FaceSeries(out_dir, "step", steps, "strip")
    drawn = sorted(set(np.linspace(0, steps - 1, min(DRAWN, steps)).round().astype(int).tolist()))
    inputs = [first, second, model]
    with _staged(series, overwrite, inputs) as files, progress_bar("faces") as report:
        start, start_note = load_latent_face(first, drawing.model, anew=model is None)
        end, end_note = load_latent_face(second, drawing.model, anew=model is None)
        walk = enumerate(interpolate_faces(start, end, drawing.model, steps))
        faces = ((face, {"weight": k / (steps - 1)} | soundness(face, drawing.model)) for k, face in walk)
        rows, views = series.write(files, faces, drawing, drawn, report)
        about = {"model_id": start.model_id, "subdivide": levels, "faces": rows}
        write_png(files[-2], film_strip(views, [series.stems[number] for number in drawn]))
        write_json(files[-1], provenance("interpolate", [first, second], **about))
    flipped = 100 * max(row["flipped"] for row in rows)
    echo_result(f"{out_dir}: {steps} faces, flipped triangles at most {flipped:.3f} %", start_note, end_note)


def _staged(series, overwrite, inputs):
    """Stage the files of a series, and those of what its faces wear."""
    return staged(*series.files, overwrite=overwrite, inputs=inputs, optional=series.optional)
