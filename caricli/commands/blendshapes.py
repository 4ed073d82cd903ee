"""caricli blendshapes: the expressions of a caricature from one picture of it."""

import time
from dataclasses import astuple, replace

import click

from caricli.commands.shared.dynamic_texture import dynamic_texture_option, load_network, load_painter
from caricli.commands.shared.face_outputs import note_source
from caricli.commands.shared.head_options import head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    detector_option,
    model_option,
    out_option,
    overwrite_option,
    pts_origin_option,
    refuse_unread,
    seed_option,
)
from caricli.commands.shared.picture import picture_files, picture_option
from caricli.errors import InputError, naming, shown
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.expressions.settings import METHODS, RECONSTRUCTIONS, BlendshapeSettings, BlendshapeWeights

DEFAULT_WEIGHTS = astuple(BlendshapeWeights())


@click.command()
@click.argument("source", type=PATH, metavar="FACE.npz|PICTURE|LANDMARKS")
@out_option("B.npz", "Write the blendshapes here; B.glb, .json and .png go beside it.", suffix=".npz")
@click.option(
    "--expressions",
    type=PATH,
    metavar="FILE",
    help="Make the expressions of this YAML or JSON file.  [default: ARKit's 52]",
)
@click.option(
    "--method",
    type=click.Choice(METHODS),
    default=BlendshapeSettings.method,
    help="Optimise displacements (full), stop before that (initial), or transfer those of the normal face (transfer).",
)
@click.option(
    "--reconstruct",
    type=click.Choice(RECONSTRUCTIONS),
    default=BlendshapeSettings.reconstruct,
    help="Let faces follow landmarks by the deformation of their surface (intrinsic), or inside a model (latent).",
)
@click.option(
    "--weights",
    nargs=3,
    type=FiniteRange(0, 1e6),
    default=DEFAULT_WEIGHTS,
    metavar="DEF STR SMO",
    help="Weigh deformation, structure and smoothness against each other, for --method full.",
)
@click.option(
    "--map",
    "map_path",
    type=PATH,
    metavar="MAP",
    help="Use this map of `caricli train landmark-map`.  [default: bundled]",
)
@model_option
@click.option(
    "--templates",
    type=PATH,
    metavar="DIR",
    help="Take the actions from meshes in this folder: neutral.obj, and one for each.  [default: the head's]",
)
@head_options
@click.option(
    "--texture", type=PATH, metavar="IMAGE", help="Put this picture on the skin.  [default: the one that the face has]"
)
@dynamic_texture_option("Paint the skin as expressions show it: those of --expressions, or else eight moods.")
@detector_option
@pts_origin_option
@seed_option
@picture_option
@overwrite_option
def command(
    source,
    out,
    expressions,
    method,
    reconstruct,
    weights,
    map_path,
    model,
    templates,
    head,
    texture,
    dynamic,
    network,
    detector,
    pts_origin,
    seed,
    overwrite,
):
    """Make the expressions of a caricature, as blendshapes that keep who it is, from one picture of it.

    Its landmarks become those of a normal face, a normal face is fitted and does the expressions, and they are carried
    back. FACE.npz is of `reconstruct-from-landmarks` or `refine`; the face of a PICTURE, or of LANDMARKS, is
    reconstructed first. The landmarks that were found in a PICTURE go to B-landmarks.json. Every expression starts from
    the neutral one, which the drawing need not show, and which is found with caution. FILE has a line `neutral: {}` and
    others such as `smile: {mouthSmile: 0.7}`, of the 52 actions of ARKit. With --dynamic-texture B.npz and B.glb have a
    picture of the skin for every mood, in B.glb a variant of its material (KHR_materials_variants), and what every
    expression does to the skin in one texture, for shaders (docs/engines.md). Use B.npz with `caricli retarget` and
    `caricli animate`.

    \b
    Example:
      caricli blendshapes face.npz --out blendshapes.npz
      caricli blendshapes drawing.png --out blendshapes.npz
      caricli blendshapes landmarks.json --expressions moods.yaml --out moods.npz
      caricli blendshapes face.npz --method transfer --out rival.npz
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.expressions.rig_blendshapes import report_blendshapes
    from caricli.methods.rig.make_rig import RigSettings
    from caricli.store.expression_tools import ToolPaths, caricature_pictures, load_caricature, load_tools
    from caricli.store.face_pictures import FaceReader, seen_files

    _check_usage(source, method, reconstruct, weights)
    painting = load_network(network, dynamic)
    settings = BlendshapeSettings(method, reconstruct, BlendshapeWeights(*weights))
    tools, tool_files = load_tools(ToolPaths(expressions, map_path, model, templates), latent=reconstruct == "latent")
    inputs = [source, *caricature_pictures(source, texture).files, *tool_files, network]
    others = [*map(out.with_suffix, (".glb", ".json")), *picture_files(out.with_suffix(".png"))]
    given = {"overwrite": overwrite, "inputs": [*inputs, detector], "optional": seen_files(source, out)}
    with staged(out, *others, **given) as files:
        caricature = load_caricature(source, tools, texture, FaceReader(detector, pts_origin))
        _check_worn(source, caricature, painting)
        with naming(source), progress_bar("expressions"):
            blendshapes, seconds = _build(caricature.face, tools, settings)
            result = _rigged(caricature, blendshapes, tools, RigSettings(head=head, seed=seed))
            result = _painted(result, source, tools, painting)
        about = {"method": method, "reconstruct": reconstruct, "weights": weights, "seconds": seconds}
        about |= note_source(files[0], caricature.source, source)
        figures, line = report_blendshapes(caricature.face, blendshapes, tools, result)
        _write(files, caricature.face, result, provenance("blendshapes", inputs, seed, **about, **figures))
    echo_result(f"{out}: {line}")


def _check_usage(source, method, reconstruct, weights):
    """Refuse options that the source or the method does not use."""
    refuse_unread([source])
    if method == "transfer" and reconstruct != "intrinsic":
        raise click.UsageError("--reconstruct is for methods that follow landmarks, not for transfer.")
    if method != "full" and weights != DEFAULT_WEIGHTS:
        raise click.UsageError("--weights are those of --method full.")


def _check_worn(source, caricature, painting):
    """Refuse a Caricature of a file without a texture that is to be painted, before anything takes its time."""
    if painting is not None and caricature.worn.skin is None:
        raise InputError(
            f"{shown(source)}: dynamic texture needs a face with a picture on its skin, as `caricli texture` writes one"
        )


def _build(face, tools, settings):
    """The Blendshapes of a Face, and the seconds that they took."""
    from caricli.methods.expressions.build_blendshapes import build_blendshapes

    start = time.perf_counter()
    blendshapes = build_blendshapes(face, tools, settings)
    return blendshapes, time.perf_counter() - start


def _rigged(caricature, blendshapes, tools, settings):
    """The RigResult of a Caricature's Blendshapes. settings: RigSettings."""
    from caricli.methods.expressions.rig_blendshapes import rig_blendshapes

    return rig_blendshapes(blendshapes, tools, settings, caricature.worn.load(), caricature.face)


def _painted(result, source, tools, network):
    """A RigResult of a file with pictures of the skin in moods. network: TextureModel, or None to leave it."""
    from caricli.store.texture_networks import paint_moods

    painter = load_painter(result.rig, source, network, tools.morphable.template)
    if painter is None:
        return result
    return replace(result, rig=paint_moods(result.rig, painter, tools.expressions))


def _write(files, face, result, description):
    """Write NPZ, GLB, JSON and picture of a RigResult."""
    from caricli.commands.shared.expression_picture import write_expression_sheet
    from caricli.io.gltf.write_gltf import write_gltf
    from caricli.io.rig import write_rig

    npz, glb, json, *pngs = files
    write_rig(npz, result.rig)
    write_gltf(glb, result.rig)
    write_json(json, description)
    for png in pngs:
        write_expression_sheet(png, result.rig, result.as_given(face))
