"""caricli texture: the picture on the face."""

import time

import click

from caricli.commands.shared.options import PATH, model_option, out_option, overwrite_option, seed_option
from caricli.errors import naming
from caricli.io.image import read_image, write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.texture.settings import PaintSettings

REPORT = "face.json"
SIZE = 320


@click.command()
@click.argument("face", type=PATH)
@click.argument("image", type=PATH)
@out_option("DIR", "A folder for face.obj, .mtl, .npz, .glb, .json, texture.png, eyes.png and sheet.png.")
@click.option("--mask", type=PATH, metavar="MASK.png", help="White where the head is.  [default: cut out by colours]")
@click.option(
    "--size",
    type=click.IntRange(64, 4096),
    metavar="PIXELS",
    help="Side of the texture.  [default: 1024 or more, as fine as the picture]",
)
@click.option("--project-uv", "flat", is_flag=True, help="The picture itself as texture, as published, to compare.")
@model_option
@seed_option
@overwrite_option
def command(face, image, out, mask, size, flat, model, seed, overwrite):
    """Paint a face (NPZ with a camera) with the picture that it was fitted to.

    What the picture does not show comes from the other side of the face, and else from what surrounds it; background
    never enters. eyes.png is painted in the colours of the eyes. `caricli rig` takes both pictures along.

    \b
    Example:
      caricli texture refined.npz drawing.png --out textured
      caricli texture face.npz photo.jpg --mask head.png --size 2048 --out textured
      caricli rig textured/face.npz --out rig.glb
    """
    from caricli.methods.texture.paint_head import paint_head
    from caricli.render.texture_sheet import texture_sheet
    from caricli.store.faces import load_seen_face, write_painted_head
    from caricli.store.pictures import load_mask

    inputs = (face, image, mask, model)
    with staged_folder(out, overwrite=overwrite, inputs=inputs, marker=REPORT) as folder:
        seen, shape_model = load_seen_face(face, model)
        picture = read_image(image)
        with naming(face):
            seen.require_landmarks()
        head = load_mask(mask, image, seen, picture)
        start = time.perf_counter()
        painted = paint_head(seen, shape_model.template, picture, head, PaintSettings(size, flat, seed))
        seconds = time.perf_counter() - start
        write_painted_head(folder, painted, seen)
        about = {"project_uv": flat, "seconds": seconds, "model_id": shape_model.model_id, "head": float(head.mean())}
        report = provenance("texture", inputs[:3], seed, **about, **painted.figures())
        write_json(folder / REPORT, report)
        write_png(folder / "sheet.png", texture_sheet(painted.head, painted.rig, SIZE))
    click.echo(f"{out}: {painted.describe()}, {seconds:.1f} s")
