"""caricli interpolate: from one face to another."""

import click
import numpy as np

from caricli.commands.shared.options import PATH, model_option, overwrite_option, subdivide_option
from caricli.io.image import write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

DRAWN, SIZE = 12, 256


@click.command()
@click.argument("first", type=PATH, metavar="A")
@click.argument("second", type=PATH, metavar="B")
@click.option(
    "--steps", type=click.IntRange(2, 1000), default=7, metavar="N", help="Number of faces, A and B among them."
)
@click.option("--out-dir", type=PATH, required=True, metavar="DIR", help="The folder for the faces and their strip.")
@model_option
@subdivide_option
@overwrite_option
def command(first, second, steps, out_dir, model, levels, overwrite):
    """Go from face A to face B (OBJ or NPZ) in equal steps: step-000.obj and .npz and so on, strip.png and strip.json.

    The latents run along a straight line, and so does what they cannot express. A face without a latent is encoded
    first, and without --model also one whose latent is of another bundled model than the default. The strip shows at
    most 12 of the steps.

    \b
    Example:
      caricli interpolate faces/face-000.npz faces/face-001.npz --steps 9 --out-dir between
      caricli interpolate neutral.obj smile.obj --steps 5 --out-dir smiling --subdivide 1
    """
    from caricli.commands.series import draw_series_face, series_paths, write_series_face
    from caricli.commands.shared.progress import progress_bar
    from caricli.geometry.flipped_triangles import flipped_triangles
    from caricli.methods.faces.interpolate_faces import interpolate_faces
    from caricli.render.contact_sheet import contact_sheet
    from caricli.store.faces import load_latent_face
    from caricli.store.models import DEFAULT_LATENT, load_model
    from caricli.template.fine_mesh import fine_mesh

    shape_model = load_model(model, DEFAULT_LATENT)
    fine = fine_mesh(shape_model.template, levels)
    paths, rows, pictures = series_paths(out_dir, "step", steps, "strip"), [], []
    drawn = set(np.linspace(0, steps - 1, min(DRAWN, steps)).round().astype(int).tolist())
    with staged(*paths, overwrite=overwrite, inputs=[first, second, model]) as files, progress_bar("faces") as report:
        (start, _, start_note), (end, _, end_note) = (
            load_latent_face(path, shape_model, anew=model is None) for path in (first, second)
        )
        for number, face in enumerate(interpolate_faces(start, end, shape_model, steps)):
            finer = write_series_face(files[2 * number : 2 * number + 2], face, shape_model, fine)
            if number in drawn:
                pictures.append(np.vstack(draw_series_face(face, finer, shape_model, fine, SIZE)))
            flipped = float(flipped_triangles(face.vertices, shape_model.template.gradients).mean())
            figures = {"prior_rms": face.prior_rms, "flipped": flipped}
            rows.append({"face": paths[2 * number].stem, "weight": number / (steps - 1)} | figures)
            report(number + 1, steps)
        write_png(files[-2], contact_sheet(pictures, len(pictures), [rows[number]["face"] for number in sorted(drawn)]))
        known = {"model_id": shape_model.model_id, "subdivide": levels, "faces": rows}
        write_json(files[-1], provenance("interpolate", [first, second], **known))
    for note in filter(None, (start_note, end_note)):
        click.echo(note, err=True)
    click.echo(f"{out_dir}: {steps} faces, flipped triangles at most {100 * max(r['flipped'] for r in rows):.3f} %")
