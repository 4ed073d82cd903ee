"""caricli dataset show: what is in a dataset."""

import click
import numpy as np

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import PATH, WholeRange, out_option, overwrite_option, seed_option
from caricli.io.image import write_png
from caricli.io.outputs import staged


@click.command()
@click.argument("dataset", type=PATH)
@out_option("PNG", "Draw random meshes on this contact sheet.", required=False, suffix=".png")
@click.option("--faces", type=WholeRange(1, 400), default=35, metavar="N", help="Draw N meshes on the sheet.")
@click.option("--size", type=WholeRange(32, 1024), default=200, metavar="PIXELS", help="Draw views this wide and high.")
@seed_option
@overwrite_option
def command(dataset, out, faces, size, seed, overwrite):
    """Print counts, flipped triangles and how many principal components explain 99 % of the variance.

    For comparison, the deformable paper counts 178 for 3DCaricShop and 52 for FaceWarehouse.

    \b
    Example:
      caricli dataset show dataset -o sheet.png
    """
    from caricli.data.dataset import read_dataset
    from caricli.data.summarise_dataset import summarise_dataset
    from caricli.render.dataset_sheet import dataset_sheet
    from caricli.store.datasets import dataset_files

    data = read_dataset(dataset)
    if out is not None:
        with staged(out, overwrite=overwrite, inputs=dataset_files(dataset)) as (temporary,):
            sheet = dataset_sheet(data.vertices, data.template, faces, size, np.random.default_rng(seed))
            write_png(temporary, sheet)
        echo_result(f"{out}: {min(faces, len(data.vertices))} meshes drawn")
    for line in summarise_dataset(data):
        click.echo(line)
