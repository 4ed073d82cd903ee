"""caricli sample: random faces."""

from itertools import islice

import click
import numpy as np

from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    FiniteRange,
    WholeRange,
    model_option,
    out_folder_option,
    overwrite_option,
    seed_option,
    subdivide_option,
)
from caricli.io.image import write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

DRAWN = 100
SIZE = 200


@click.command()
@out_folder_option("Write the faces and their sheet into this folder.", required=True)
@click.option("--count", type=WholeRange(1, 10_000), default=20, metavar="N", help="Draw N random faces.")
@click.option(
    "--spread",
    type=FiniteRange(0, 10),
    default=1.0,
    metavar="S",
    help="Multiply the prior's standard deviation by S: smaller stays nearer to the mean face.",
)
@seed_option
@model_option
@mesh_head_options
@subdivide_option
@overwrite_option
def command(out_dir, count, spread, seed, model, head, levels, overwrite):
    """Draw random faces from a model's prior: face-000.obj and .npz and so on, sheet.png and sheet.json.

    Flipped triangles are turned back and eye sockets and mouth tucked behind the skin; a face that keeps more than
    0.2 % flipped triangles is drawn again. Faces of a morphable model wear random colours of it. The sheet shows the
    first 100 faces.

    \b
    Example:
      caricli sample --out-dir faces --count 20
      caricli sample --out-dir fine --count 3 --seed 7 --spread 0.8 --subdivide 2
      caricli sample --out-dir people --model morphable
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.faces.sample_faces import sample_faces
    from caricli.render.sheets.contact_sheet import contact_sheet
    from caricli.store.drawings import load_drawing
    from caricli.store.face_files import FaceSeries

    drawing = load_drawing(model, levels, SIZE, head)
    series = FaceSeries(out_dir, "face", count, "sheet")
    given = {"overwrite": overwrite, "inputs": [model], "optional": series.optional}
    with staged(*series.files, **given) as files, progress_bar("faces") as report:
        samples = islice(sample_faces(drawing.model, np.random.default_rng(seed), spread), count)
        faces = ((sample.face, sample.figures()) for sample in samples)
        rows, views = series.write(files, faces, drawing, range(DRAWN), report)
        about = {"model_id": drawing.model.model_id, "spread": spread, "subdivide": levels, "faces": rows}
        write_png(files[-2], contact_sheet([np.hstack(pair) for pair in views], labels=series.stems[:DRAWN]))
        write_json(files[-1], provenance("sample", [], seed, **about))
    rejected = sum(row["rejected"] for row in rows)
    flipped = 100 * np.mean([row["flipped"] for row in rows])
    echo_result(f"{out_dir}: {count} faces, {rejected} draws rejected, flipped triangles {flipped:.3f} %")
