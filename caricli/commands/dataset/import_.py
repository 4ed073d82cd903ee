"""caricli dataset import: anyone's registered meshes."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import PATH, overwrite_option, seed_option
from caricli.io.outputs import staged_folder


@click.command()
@click.argument("obj_dir", type=PATH, metavar="MESH_DIR")
@click.argument("out", type=PATH, metavar="OUT_DIR")
@click.option(
    "--annotation", type=PATH, required=True, metavar="JSON", help="Read from this file which vertices are landmarks."
)
@click.option(
    "--labels",
    type=PATH,
    metavar="CSV",
    help="Read labels from a table, its columns between commas or semicolons: a row for every mesh, columns for file, "
    "identity, expression and level (these three are optional) and labels, which are numbers.",
)
@click.option(
    "--unit",
    type=click.Choice(["m", "dm", "cm", "mm"]),
    help="Take the files as given in this unit.  [default: measured]",
)
@seed_option
@overwrite_option
def command(obj_dir, out, annotation, labels, unit, seed, overwrite):
    """Import a folder of meshes that share one topology: OBJ files, or else PLY, GLB or glTF.

    Vertex count, quads and UV seams are free, and the order of vertices is kept. The first file by name gives faces,
    and the first that has UVs gives these; the template is the mean shape. Whom a file shows, with which expression and
    how exaggerated (level 1 is not), is in the table, or else in its name, such as anna__jawOpen__2.obj,
    anna__jawOpen.obj, anna.obj. The unit is told by how high the heads are; the dataset is in metres. Names and seed
    say who is trained with and who tests, so that most stay where they were when others come in. A mesh that is far
    from the size, the place or the direction of the others is refused, and so is one that two people have. Refused
    are also heads whose mean, by its landmarks, lies, looks aside or is mirrored, heads inside out, and STL, whose
    vertices have no numbers that an annotation could mean.

    \b
    Example:
      caricli dataset import scans dataset --annotation annotation.json
      caricli dataset import scans dataset --annotation annotation.json --labels labels.csv --unit cm
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.dataset import MANIFEST
    from caricli.data.import_dataset import ImportSettings, import_dataset

    inputs = (obj_dir, annotation, labels)
    with (
        staged_folder(out, overwrite=overwrite, inputs=inputs, marker=MANIFEST) as temporary,
        progress_bar("meshes") as report,
    ):
        summary = import_dataset(obj_dir, temporary, annotation, labels, ImportSettings(unit, seed), report)
    echo_result(f"{out}: {summary.describe()}", *summary.notes)
