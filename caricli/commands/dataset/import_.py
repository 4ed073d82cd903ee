"""caricli dataset import: anyone's registered meshes."""

import click

from caricli.commands.shared.options import PATH, overwrite_option, seed_option
from caricli.io.outputs import staged_folder


@click.command()
@click.argument("obj_dir", type=PATH, metavar="OBJ_DIR")
@click.argument("out", type=PATH, metavar="OUT_DIR")
@click.option("--annotation", type=PATH, required=True, metavar="JSON", help="Landmark vertices of the topology.")
@click.option("--labels", type=PATH, metavar="CSV", help="One row a mesh: file, identity (optional), label columns.")
@seed_option
@overwrite_option
def command(obj_dir, out, annotation, labels, seed, overwrite):
    """Take a folder of OBJ meshes that share one topology: any vertex count, quads, UV seams, order kept.

    The first file by name gives faces and UVs; the template is the mean shape. Without an identity column every mesh
    is a person of its own.

    \b
    Example:
      caricli dataset import scans dataset --annotation annotation.json
      caricli dataset import scans dataset --annotation annotation.json --labels labels.csv
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.import_dataset import import_dataset

    inputs = (obj_dir, annotation, labels)
    with (
        staged_folder(out, overwrite=overwrite, inputs=inputs, marker="dataset.json") as temporary,
        progress_bar("meshes") as report,
    ):
        count = import_dataset(obj_dir, temporary, annotation, labels, seed, report)
    click.echo(f"{out}: {count} meshes")
