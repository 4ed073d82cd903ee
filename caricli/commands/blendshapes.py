"""caricli blendshapes: the expressions of a caricature from one picture of it."""

import time

import click
import numpy as np

from caricli.commands.shared.options import PATH, FiniteRange, out_option, overwrite_option, seed_option
from caricli.errors import CaricliError, shown
from caricli.io.image import write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

WEIGHTS = 1.0, 0.1, 0.05


@click.command()
@click.argument("source", type=PATH, metavar="FACE.npz|LANDMARKS")
@out_option("B.npz", "The blendshapes; B.glb, .json and .png are written beside it.", suffix=".npz")
@click.option(
    "--expressions", type=PATH, metavar="FILE", help="YAML or JSON with what to make.  [default: 46 of ARKit's]"
)
@click.option(
    "--method",
    type=click.Choice(["full", "initial", "transfer"]),
    default="full",
    help="Optimise the displacements, stop before, or transfer those of the normal face.",
)
@click.option(
    "--reconstruct",
    type=click.Choice(["intrinsic", "latent"]),
    default="intrinsic",
    help="How faces follow the landmarks of their expressions.",
)
@click.option(
    "--weights",
    nargs=3,
    type=FiniteRange(0, 1e6),
    default=WEIGHTS,
    metavar="DEF STR SMO",
    help="Of deformation, structure and smoothness.",
)
@click.option("--map", "map_path", type=PATH, metavar="MAP", help="Of caricli train landmark-map.  [default: bundled]")
@click.option("--model", type=PATH, metavar="MODEL", help="Of caricli train morphable.  [default: bundled]")
@click.option("--templates", type=PATH, metavar="DIR", help="Your own neutral.obj and actions, one OBJ for each.")
@click.option("--eyeballs/--no-eyeballs", default=True, help="Put eyes into the sockets, as part of the mesh.")
@click.option("--texture", type=PATH, metavar="IMAGE", help="The picture on the skin.  [default: the face's own]")
@click.option("--pts-origin", type=click.IntRange(0, 1), default=1, help="Coordinate of the first pixel in .pts files.")
@seed_option
@overwrite_option
def command(source, out, expressions, method, reconstruct, weights, map_path, model, templates, eyeballs, texture,
            pts_origin, seed, overwrite):  # fmt: skip
    """Make the expressions of a caricature, as blendshapes that keep who it is, from one picture of it.

    Its landmarks become those of a normal face, a normal face is fitted and does the expressions, and they are carried
    back. FACE.npz is of `reconstruct-from-landmarks` or `refine`; LANDMARKS are reconstructed first. Every expression
    starts from the neutral one, which the drawing need not show, and which is found with caution. FILE has a line
    `neutral: {}` and others such as `smile: {mouthSmile: 0.7}`, of the 52 actions of ARKit. Use B.npz with `caricli
    retarget` and `caricli animate`.

    \b
    Example:
      caricli blendshapes face.npz --out blendshapes.npz
      caricli blendshapes landmarks.json --expressions moods.yaml --out moods.npz
      caricli blendshapes face.npz --method transfer --out rival.npz
    """
    from caricli.commands.blended import build, load_caricature, load_tools, report, with_given
    from caricli.commands.rigging import expression_sheet
    from caricli.commands.shared.progress import progress_bar
    from caricli.io.gltf.write_gltf import write_gltf
    from caricli.io.rig import write_rig
    from caricli.methods.expressions.optimise_blendshapes import BlendshapeWeights

    if method == "transfer" and reconstruct != "intrinsic":
        raise click.UsageError("--reconstruct is for methods that follow landmarks, not for transfer.")
    if method != "full" and weights != WEIGHTS:
        raise click.UsageError("--weights are those of --method full.")
    tools = load_tools(expressions, map_path, model, templates, reconstruct)
    face = load_caricature(source, tools.morphable, texture, pts_origin)
    files = [out, *(out.with_suffix(suffix) for suffix in (".glb", ".json", ".png"))]
    inputs = face.inputs + tools.inputs
    with staged(*files, overwrite=overwrite, inputs=inputs) as (npz, glb, json, png):
        try:
            start = time.perf_counter()
            made = build(tools, face, method, BlendshapeWeights(*weights))
            seconds = time.perf_counter() - start
            rig, measures, _ = tools.rig(made, np.random.default_rng(seed), eyeballs, face.pictures)
        except CaricliError as error:
            raise type(error)(f"{shown(source)}: {error}") from error
        write_rig(npz, rig)
        write_gltf(glb, rig)
        figures, line = report(tools, face, made, rig, measures)
        about = {"method": method, "reconstruct": reconstruct, "weights": weights, "seconds": seconds}
        write_json(json, provenance("blendshapes", inputs, seed, **about, **figures))
        with progress_bar("drawing") as progress:
            write_png(png, expression_sheet(rig, progress, with_given(rig, face)))
    click.echo(f"{out}: {line}, {seconds:.2f} s")
