"""caricli texture: the picture on the face."""

import time

import click
import numpy as np

from caricli.commands.shared.options import PATH, model_option, out_option, overwrite_option, seed_option
from caricli.io.image import read_image
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

REPORT = "face.json"


@click.command()
@click.argument("face", type=PATH)
@click.argument("image", type=PATH)
@out_option("DIR", "A folder for face.obj, .mtl, .npz, .glb, .json, texture.png, eyes.png and sheet.png.")
@click.option("--mask", type=PATH, metavar="MASK.png", help="White where the head is.  [default: cut out by colours]")
@click.option("--size", type=click.IntRange(64, 4096), metavar="PIXELS", help="Side of the texture.  [default: 1024 or "
              "more, as fine as the picture]")  # fmt: skip
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
    from caricli.commands.textured import head_mask, paint, write_textured
    from caricli.store.faces import load_seen_face

    with staged_folder(out, overwrite=overwrite, inputs=(face, image, mask, model), marker=REPORT) as folder:
        seen, shape_model, pose = load_seen_face(face, model)
        picture, generator = read_image(image), np.random.default_rng(seed)
        cut = head_mask(mask, picture, seen, pose, shape_model.template, (face, image))
        start = time.perf_counter()
        painted = paint(seen, pose, picture, cut, shape_model.template, size, flat, generator)
        seconds = time.perf_counter() - start
        write_textured(folder, painted, seen, shape_model)
        about = {"project_uv": flat, "seconds": seconds, "model_id": shape_model.model_id, "head": float(cut.mean())}
        figures = {"size": len(painted.rig.texture), "photometric_error": painted.error, "seen": painted.seen}
        write_json(folder / REPORT, provenance("texture", [face, image, mask], seed, **about, **figures))
    shown = f"{100 * painted.seen:.0f} % of the surface seen, photometric error {100 * painted.error:.2f} %"
    click.echo(f"{out}: {shown}, {seconds:.1f} s")
