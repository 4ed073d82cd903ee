"""caricli dataset show: what is in a dataset."""

import click
import numpy as np

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import PATH, WholeRange, out_option, overwrite_option, refuse_typed, seed_option
from caricli.errors import shown
from caricli.io.image import write_png
from caricli.io.outputs import staged

_OF_SHEET = ("faces", "size", "seed", "overwrite")


@click.command()
@click.argument("dataset", type=PATH)
@out_option("PNG", "Draw some at random on this contact sheet.", required=False, suffix=".png")
@click.option("--faces", type=WholeRange(1, 400), default=35, metavar="N", help="Draw N on the sheet.")
@click.option(
    "--size", type=WholeRange(32, 1024), default=200, metavar="PIXELS", help="Draw views of meshes this wide and high."
)
@seed_option
@overwrite_option
def command(dataset, out, faces, size, seed, overwrite):
    """Print what is in a dataset of meshes, of pictures or of textures, and draw a part of it.

    Of meshes it prints counts, flipped triangles and how many principal components explain 99 % of the variance; for
    comparison, the deformable paper counts 178 for 3DCaricShop and 52 for FaceWarehouse. Of pictures it draws each
    beside its label map and landmarks, those that are hidden in red; of textures it draws a row for every person.

    \b
    Example:
      caricli dataset show dataset -o sheet.png
      caricli dataset show pictures -o sheet.png --faces 24
    """
    from caricli.store.datasets import dataset_files, is_picture_set, is_texture_set

    if out is None:
        refuse_typed("--faces, --size, --seed and --overwrite are of the sheet of --out.", *_OF_SHEET)
    generator = np.random.default_rng(seed)
    summary = _pictures if is_picture_set(dataset) else _textures if is_texture_set(dataset) else _meshes
    lines, draw = summary(dataset, faces, size, generator)
    if out is not None:
        with staged(out, overwrite=overwrite, inputs=dataset_files(dataset)) as (temporary,):
            write_png(temporary, draw())
        echo_result(f"{out}: drawn")
    for line in lines:
        click.echo(shown(line))


def _meshes(folder, count, size, generator):
    """Lines that describe a dataset of meshes, and a function that draws its sheet."""
    from caricli.data.dataset import read_dataset
    from caricli.data.summarise_dataset import summarise_dataset
    from caricli.methods.faces.dataset_sheet import dataset_sheet

    data = read_dataset(folder)
    return summarise_dataset(data), lambda: dataset_sheet(data.vertices, data.template, count, size, generator)


def _pictures(folder, count, size, generator):
    """The same of a dataset of pictures, which keep their own size."""
    from caricli.data.picture_set import read_picture_set
    from caricli.data.summarise_pictures import chosen_pictures, summarise_pictures
    from caricli.render.sheets.picture_sheet import picture_sheet

    pictures = read_picture_set(folder)
    return summarise_pictures(pictures), lambda: picture_sheet(chosen_pictures(pictures, count, generator))


def _textures(folder, count, size, generator):
    """The same of a dataset of textures."""
    from caricli.data.summarise_textures import chosen_textures, summarise_textures
    from caricli.data.texture_set import read_texture_set
    from caricli.render.sheets.contact_sheet import contact_sheet

    textures = read_texture_set(folder)
    lines = summarise_textures(textures)
    return lines, lambda: contact_sheet(list(chosen_textures(textures, count, generator)), columns=1)
