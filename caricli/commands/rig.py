"""caricli rig: a face that moves."""

import click

from caricli.commands.shared.options import PATH, out_option, overwrite_option, seed_option
from caricli.errors import naming
from caricli.io.image import write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


@click.command()
@click.argument("face", type=PATH)
@out_option("RIG.glb", "The rig; RIG.npz, .json and .png are written beside it.", suffix=".glb")
@click.option("--templates", type=PATH, metavar="DIR", help="Your own neutral.obj and expressions, one OBJ for each.")
@click.option("--eyeballs/--no-eyeballs", default=True, help="Put eyes into the sockets, as part of the mesh.")
@click.option("--texture", type=PATH, metavar="IMAGE", help="The picture on the skin.  [default: the OBJ's own]")
@click.option("--sparse", is_flag=True, help="Store only what moves: a smaller GLB, which fewer programs read.")
@click.option("--usd", is_flag=True, help="Write RIG.usdc too, with UsdSkel blend shapes; needs caricli[usd].")
@click.option(
    "--subdivide",
    "levels",
    type=click.IntRange(0, 4),
    default=0,
    metavar="N",
    help="Split the polygons of the face N times, in every file.",
)
@seed_option
@overwrite_option
def command(face, out, templates, eyeballs, texture, sparse, usd, levels, seed, overwrite):
    """Give a neutral face (OBJ or NPZ) the 52 expressions of ARKit by deformation transfer.

    Lids close and lips meet as they do on the template, whatever the shape of the face; what no expression moves stays
    where it is. mouthClose is drawn on top of jawOpen, as it is meant. `caricli inspect` says what is in the result.

    \b
    Example:
      caricli rig face.npz --out rig.glb
      caricli rig face.obj --subdivide 1 --sparse --out fine.glb
      caricli rig scan.obj --templates expressions --out rig.glb
    """
    from caricli.methods.rig.make_rig import RigSettings, make_rig
    from caricli.methods.rig.rig_figures import describe_rig, lips_are_apart, rig_figures
    from caricli.store.expression_templates import load_action_units, load_templates
    from caricli.store.rig_sources import load_neutral, picture_paths

    expressions, template_files = load_templates(templates)
    mesh = load_neutral(face, expressions)
    pictures = picture_paths(face, texture)
    inputs = [face, *pictures.files, *template_files]
    suffixes = [".npz", ".json", ".png", *([".usdc"] if usd else [])]
    with staged(out, *map(out.with_suffix, suffixes), overwrite=overwrite, inputs=inputs) as files:
        images = pictures.load()
        with naming(face):
            result = make_rig(mesh, expressions, RigSettings(levels, eyeballs, seed), images)
        about = {"subdivide": levels, "sparse": sparse, "units": "m", "axes": "+y up, +z front"}
        figures = rig_figures(result, load_action_units())
        _write(files, result.rig, sparse, provenance("rig", inputs, seed, **about, **figures))
    if lips_are_apart(result):
        click.echo(f"{face}: its lips are apart, and stay so where no expression closes them", err=True)
    click.echo(f"{out}: {describe_rig(result)}")


def _write(files, rig, sparse, description):
    """Write GLB, NPZ, JSON and picture of a Rig, and USD where there is a fifth file."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.io.gltf.write_gltf import write_gltf
    from caricli.io.rig import write_rig
    from caricli.io.usd import write_usd
    from caricli.render.expression_sheet import expression_sheet

    glb, npz, json, png, *usdc = files
    write_gltf(glb, rig, sparse)
    write_rig(npz, rig)
    for path in usdc:
        write_usd(path, rig)
    write_json(json, description)
    with progress_bar("drawing") as progress:
        write_png(png, expression_sheet(rig, progress))
