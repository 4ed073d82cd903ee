"""caricli render: shaded pictures of faces."""

import click
import numpy as np

from caricli.commands.shared.options import PATH, out_option, overwrite_option
from caricli.errors import InputError, OutputError, shown
from caricli.io.face import read_face
from caricli.io.image import read_image, write_png
from caricli.io.outputs import staged
from caricli.limits import MAX_IMAGE_PIXELS
from caricli.render.contact_sheet import contact_sheet
from caricli.render.overlay import overlay_mesh
from caricli.render.place_eyeballs import place_eyeballs
from caricli.render.shade import Look
from caricli.render.views import VIEWS, render_views, turntable
from caricli.template.annotation import bundled_annotation


def _views(ctx, param, value):
    names = tuple(name.strip() for name in value.split(","))
    unknown = [name for name in names if name not in VIEWS]
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r} is not one of {', '.join(VIEWS)}.")
    return names


@click.command()
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="FACE...")
@out_option("PNG", "The picture to write.", suffix=".png")
@click.option(
    "--views",
    callback=_views,
    default="front,three-quarter,profile",
    metavar="NAMES",
    help=f"Sides to look from, by comma: {', '.join(VIEWS)}.",
)
@click.option(
    "--turntable",
    "frames",
    type=click.IntRange(1, 360),
    metavar="N",
    help="Instead of the views, N pictures of one turn.",
)
@click.option("--size", type=click.IntRange(16, 4096), default=512, metavar="PIXELS", help="Side of one view.")
@click.option(
    "--columns",
    type=click.IntRange(1),
    metavar="N",
    help="Pictures in a row of the sheet: faces, or with one face its views.  [default: near to a square; "
    "the views of one face in one row]",
)
@click.option(
    "--image",
    type=PATH,
    metavar="IMAGE",
    help="Instead of the views, draw the face over this picture; the face must be an NPZ with a camera.",
)
@overwrite_option
def command(paths, out, views, frames, size, columns, image, overwrite):
    """Draw shaded pictures of faces (OBJ or NPZ): views side by side, a turntable, or an overlay.

    Several faces become a contact sheet with the names of their files. Heads of the bundled topology get eyeballs.

    \b
    Example:
      caricli render face.npz -o views.png
      caricli render faces/*.obj -o sheet.png --views front --size 256
      caricli render face.npz -o overlay.png --image drawing.png
    """
    if image is not None and len(paths) > 1:
        raise click.UsageError("--image takes one FACE.")
    pictures = len(paths) * (frames or len(views))
    if pictures * size * size > MAX_IMAGE_PIXELS:
        raise OutputError(
            f"{shown(out)}: {pictures} pictures of {size} x {size} are more than {MAX_IMAGE_PIXELS} pixels "
            "together; give a smaller --size"
        )
    with staged(out, overwrite=overwrite, inputs=(*paths, image)) as (temporary,):
        if image is not None:
            picture = _overlay(paths[0], image)
        else:
            strips = [_strip(path, views, frames, size) for path in paths]
            if len(strips) == 1:
                picture = contact_sheet(strips[0], columns or (None if frames else len(views)))
            else:
                picture = contact_sheet([np.hstack(s) for s in strips], columns, [path.stem for path in paths])
        write_png(temporary, picture)
    click.echo(f"{shown(out)}: {picture.shape[1]} x {picture.shape[0]} pixels, faces: {len(paths)}")


def _strip(path, views, frames, size):
    face = read_face(path)
    look = Look(eyeballs=place_eyeballs(face.mesh, bundled_annotation()))
    if frames:
        return turntable(face.mesh, frames, size, look)
    return render_views(face.mesh, views, size, look)


def _overlay(path, image):
    face = read_face(path)
    if face.camera is None:
        raise InputError(f"{shown(path)}: expected a face NPZ with a camera to lay it over a picture, found none")
    eyeballs = place_eyeballs(face.mesh, bundled_annotation())
    return overlay_mesh(read_image(image), face.mesh, face.camera, eyeballs=eyeballs)
