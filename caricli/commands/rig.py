"""caricli rig: a face that moves."""

import click
import numpy as np

from caricli.commands.shared.options import PATH, out_option, overwrite_option, seed_option
from caricli.errors import NumericsError, shown
from caricli.io.bundled import asset_path
from caricli.io.image import read_image, write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import read_json, write_json

APART = 0.12


@click.command()
@click.argument("face", required=False, type=PATH)
@out_option("RIG.glb", "The rig; RIG.npz, .json and .png are written beside it.", False, ".glb")
@click.option("--templates", type=PATH, metavar="DIR", help="Your own neutral.obj and expressions, one OBJ for each.")
@click.option("--eyeballs/--no-eyeballs", default=True, help="Put eyes into the sockets, as part of the mesh.")
@click.option("--texture", type=PATH, metavar="IMAGE", help="The picture on the skin.  [default: the OBJ's own]")
@click.option("--sparse", is_flag=True, help="Store only what moves: a smaller GLB, which fewer programs read.")
@click.option("--usd", is_flag=True, help="Write RIG.usdc too, with UsdSkel blend shapes; needs caricli[usd].")
@click.option("--check", type=PATH, metavar="RIG.glb", help="Say what is in a GLB, anybody's, and stop.")
@click.option("--subdivide", "levels", type=click.IntRange(0, 4), default=0, metavar="N",
              help="Split the polygons of the face N times, in every file.")  # fmt: skip
@seed_option
@overwrite_option
def command(face, out, templates, eyeballs, texture, sparse, usd, check, levels, seed, overwrite):
    """Give a neutral face (OBJ or NPZ) the 52 expressions of ARKit by deformation transfer.

    Lids close and lips meet as they do on the template, whatever the shape of the face; what no expression moves stays
    where it is. mouthClose is drawn on top of jawOpen, as it is meant.

    \b
    Example:
      caricli rig face.npz --out rig.glb
      caricli rig face.obj --subdivide 1 --sparse --out fine.glb
      caricli rig scan.obj --templates expressions --out rig.glb
      caricli rig --check rig.glb
    """
    from caricli.commands.rigging import check_report, expression_sheet, face_pictures, load_mesh
    from caricli.commands.shared.progress import progress_bar
    from caricli.io.gltf.write_gltf import write_gltf
    from caricli.io.rig import write_rig
    from caricli.methods.rig.build_rig import build_rig
    from caricli.methods.rig.transfer_rig import transfer_rig
    from caricli.store.expression_templates import load_templates

    if check is not None and face is out is None:
        return click.echo(check_report(check))
    if check is not None or face is None or out is None:
        raise click.UsageError("Give a FACE and --out; or --check.")
    known, annotation, used = load_templates(templates)
    mesh, (picture, eyes) = load_mesh(face, known, annotation), face_pictures(face, texture)
    files = [out, *(out.with_suffix(suffix) for suffix in (".npz", ".json", ".png", *([".usdc"] if usd else [])))]
    with staged(*files, overwrite=overwrite, inputs=(face, picture, eyes, *used)) as (glb, npz, report, sheet, *more):
        image = None if picture is None else read_image(picture)
        try:
            generator = np.random.default_rng(seed)
            deltas = transfer_rig(known, mesh.vertices)
            pictures = image, eyes and read_image(eyes)
            rig, measures, balls = build_rig(mesh, known, deltas, generator, levels, eyeballs, *pictures)
        except NumericsError as error:
            raise NumericsError(f"{shown(face)}: {error}") from error
        write_gltf(glb, rig, sparse)
        write_rig(npz, rig)
        if usd:
            from caricli.io.usd import write_usd

            write_usd(*more, rig)
        figures = {"expressions": _rows(rig, measures), **_contacts(measures, balls)}
        about = {"subdivide": levels, "sparse": sparse, "units": "m", "axes": "+y up, +z front"}
        write_json(report, provenance("rig", [face, picture, eyes, *used], seed, **about, **figures))
        with progress_bar("drawing") as progress:
            write_png(sheet, expression_sheet(rig, progress))
    if measures.lips_open is not None and measures.lips_open > APART:
        click.echo(f"{face}: its lips are apart, and stay so where no expression closes them", err=True)
    click.echo(f"{out}: {_said(rig, measures)}")


def _rows(rig, measures):
    """What the JSON says of every expression."""
    facs, rows = read_json(asset_path("facs.json")), {}
    for k, name in enumerate(rig.names):
        known = {"strength": measures.strength[k], "contact_gap": measures.contact_gap[k]}
        rows[name] = {key: float(value) for key, value in known.items() if np.isfinite(value)}
        rows[name] |= {"flipped": float(measures.flipped[k])} | facs.get(name, {})
    return rows


def _contacts(measures, balls):
    """What the JSON says of lids, lips and eyes."""
    eyes = [{"side": b.side, "centre": b.centre, "radius": b.radius, "retreat": b.retreat} for b in balls]
    gaps = {"lid_gap": measures.lid_gap, "lip_gap": measures.lip_gap, "lids_inside_eyeballs": measures.inside}
    return {key: value for key, value in gaps.items() if value not in (None, {})} | {"eyeballs": eyes}


def _said(rig, measures):
    """The line to print."""
    moving = int(np.isfinite(measures.strength).sum())
    words = [f"{len(rig.names)} expressions ({moving} move), {len(rig.neutral)} vertices"]
    if measures.lid_gap:
        words.append(f"lids close to {100 * max(measures.lid_gap.values()):.1f} %")
    if measures.lip_gap is not None:
        words.append(f"lips to {100 * measures.lip_gap:.1f} %")
    return ", ".join([*words, f"flipped triangles at most {100 * measures.flipped.max():.3f} %"])
