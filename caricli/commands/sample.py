"""caricli sample: random faces."""

from itertools import islice

import click
import numpy as np

from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    model_option,
    overwrite_option,
    seed_option,
    subdivide_option,
)
from caricli.io.image import write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

DRAWN, SIZE = 100, 200


@click.command()
@click.option("--out-dir", type=PATH, required=True, metavar="DIR", help="The folder for the faces and their sheet.")
@click.option("--count", type=click.IntRange(1, 10_000), default=20, metavar="N", help="Number of faces.")
@click.option(
    "--spread",
    type=FiniteRange(0, 10),
    default=1.0,
    metavar="S",
    help="Factor of the prior's standard deviation; smaller stays nearer to the mean face.",
)
@seed_option
@model_option
@subdivide_option
@overwrite_option
def command(out_dir, count, spread, seed, model, levels, overwrite):
    """Draw random faces from a model's prior: face-000.obj and .npz and so on, sheet.png and sheet.json.

    Flipped triangles are turned back and eye sockets and mouth tucked behind the skin; a face that keeps more than
    0.2 % flipped triangles is drawn again. The sheet shows the first 100 faces.

    \b
    Example:
      caricli sample --out-dir faces --count 20
      caricli sample --out-dir fine --count 3 --seed 7 --spread 0.8 --subdivide 2
    """
    from caricli.commands.series import draw_series_face, series_paths, write_series_face
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.faces.sample_faces import sample_faces
    from caricli.render.contact_sheet import contact_sheet
    from caricli.store.models import DEFAULT_LATENT, load_model
    from caricli.template.fine_mesh import fine_mesh

    shape_model = load_model(model, DEFAULT_LATENT)
    fine = fine_mesh(shape_model.template, levels)
    paths, rows, pictures = series_paths(out_dir, "face", count, "sheet"), [], []
    with staged(*paths, overwrite=overwrite, inputs=[model]) as files, progress_bar("faces") as report:
        samples = islice(sample_faces(shape_model, np.random.default_rng(seed), spread), count)
        for number, sample in enumerate(samples):
            finer = write_series_face(files[2 * number : 2 * number + 2], sample.face, shape_model, fine)
            if number < DRAWN:
                pictures.append(np.hstack(draw_series_face(sample.face, finer, shape_model, fine, SIZE)))
            figures = {"prior_rms": sample.face.prior_rms, "flipped": sample.flipped}
            drawn = {"flipped_drawn": sample.flipped_drawn, "rejected": sample.rejected}
            rows.append({"face": paths[2 * number].stem} | figures | drawn)
            report(number + 1, count)
        labels = [row["face"] for row in rows[:DRAWN]]
        write_png(files[-2], contact_sheet(pictures, labels=labels))
        known = {"model_id": shape_model.model_id, "spread": spread, "subdivide": levels, "faces": rows}
        write_json(files[-1], provenance("sample", [], seed, **known))
    flipped, rejected = 100 * np.mean([row["flipped"] for row in rows]), sum(row["rejected"] for row in rows)
    click.echo(f"{out_dir}: {count} faces, {rejected} draws rejected, flipped triangles {flipped:.3f} %")
