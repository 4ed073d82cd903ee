"""caricli reconstruct-from-sketch: a drawing of lines to a 3D face."""

import click

from caricli.commands.shared.head_options import mesh_head_options
from caricli.commands.shared.options import (
    FACE_FILES,
    PATH,
    FiniteRange,
    model_option,
    out_folder_option,
    out_option,
    overwrite_option,
    subdivide_option,
)
from caricli.commands.shared.picture import picture_option
from caricli.methods.sketch.settings import COARSE


@click.command()
@click.argument("sketches", nargs=-1, required=True, type=PATH, metavar="SKETCH...")
@out_option("FACE.obj", f"Write the face of one sketch here, {FACE_FILES}", required=False)
@out_folder_option("Write the faces of many sketches into this folder, each under the name of its sketch.")
@click.option(
    "--follow",
    type=FiniteRange(0, 1),
    default=1.0,
    metavar="SHARE",
    help="Go this share of the way from the face that is likely for the lines to the lines themselves.",
)
@click.option(
    "--coarse",
    type=click.Choice(COARSE),
    help="Begin with the face that a network sees, or that a shape model allows for the lines.  [default: network]",
)
@click.option("--network", type=PATH, metavar="FILE", help="Use this network of `caricli train sketch`.")
@click.option("--strokes", type=PATH, metavar="FILE", help="Use this network of `caricli train strokes`.")
@click.option(
    "--image", type=PATH, metavar="IMAGE", help="Show the result with the picture over which the sketch was drawn."
)
@model_option
@mesh_head_options
@subdivide_option
@picture_option
@overwrite_option
@click.pass_context
def command(ctx, sketches, out, out_dir, follow, coarse, network, strokes, image, model, head, levels, overwrite):
    """Reconstruct 3D faces from sketches: lines of a face from the front.

    The likeliest face for the lines comes first: what a network sees, or an elastic one for lines that no usual face
    has. Then its curves are moved onto the lines, at the depth that they have, and the surface goes along. Strokes that
    do not name their curve find it, with what a second network reads in them, which also cuts those that draw several;
    what draws none is left out. With several SKETCHes --image is a folder of pictures with the same names. In the
    picture that is written, silhouette, features, wrinkles and what is left out are red, blue, black and grey, and the
    curves of the face are orange.

    \b
    Example:
      caricli reconstruct-from-sketch sketch.json --out face.obj
      caricli reconstruct-from-sketch photographed.jpg --out face.obj
      caricli reconstruct-from-sketch sketch.json --follow 0.5 --out face.obj
      caricli reconstruct-from-sketch sketches/*.json --out-dir faces
    """
    from caricli.commands.shared.batch import run_batch
    from caricli.commands.shared.sketch_batch import SketchTask

    task = SketchTask(sketches, out, out_dir, image, coarse, network, strokes, model, head, levels, follow, overwrite)
    run_batch(ctx, task.jobs, task.run, "faces")
