"""caricli inspect: what a file holds."""

import click

from caricli.commands.shared.options import PATH
from caricli.errors import shown


@click.command()
@click.argument("path", type=PATH, metavar="FILE")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object, for programs.")
def command(path, as_json):
    """Say what a file holds, and whether it is whole.

    FILE is anything that caricli writes (a face, a rig, a model, a landmark map, directions, landmarks, weights, a
    session, a report, a label map's legend, a folder of a dataset, of pictures, sketches or textures, or a file of
    it), or anybody's OBJ, PLY, STL, GLB or glTF. Said are counts, sizes and what
    unit they may be in, whether the topology is that of the bundled models, names, and what lies beside it. A mesh
    is whole where no triangle is turned over or without area, no vertex is unused, triangles side by side are wound
    alike, and the surface is not inside out. Of rigs every shape is looked at, and compared with the names that
    ARKit's face tracking drives.

    \b
    Example:
      caricli inspect rig.glb
      caricli inspect face.npz --json
    """
    from caricli.io.strict_json import format_json
    from caricli.methods.inspect.describe import describe
    from caricli.store.any_file import files_beside, load_acquaintances, load_any

    inspection = describe(load_any(path), load_acquaintances())
    beside = files_beside(path)
    if as_json:
        click.echo(format_json(inspection.report(str(path), beside), path), nl=False)
    else:
        click.echo(inspection.text(shown(path), beside))
