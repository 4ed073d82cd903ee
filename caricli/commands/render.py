"""caricli render: shaded pictures of faces."""

from dataclasses import replace

import click

from caricli.commands.shared.head_options import head_options
from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    WholeRange,
    named,
    out_option,
    overwrite_option,
    refuse_typed,
)
from caricli.errors import InputError, UsageError, naming, shown
from caricli.io.distinct_names import distinct_names
from caricli.io.face import read_face
from caricli.io.image import read_image, write_png
from caricli.io.outputs import staged
from caricli.limits import MAX_IMAGE_PIXELS
from caricli.render.views import VIEWS
from caricli.structures import Pictures

TURN = "turntable"
FPS = 24
FRAMES = {".png": 8, ".gif": 72, ".mp4": 96}
"""Suffixes of what can be drawn, with the usual number of pictures of one turn."""


def _views(ctx, param, value):
    names = tuple(name.strip() for name in value.split(","))
    unknown = [name for name in names if name not in VIEWS]
    if unknown and names != (TURN,):
        raise click.BadParameter(f"{unknown[0]!r} is not one of {', '.join(VIEWS)}, or {TURN} alone.")
    return names


@click.command()
@click.argument("paths", nargs=-1, required=True, type=PATH, metavar="FACE...")
@out_option("PICTURE", "Write the picture here, as .png; a turntable also as .gif or .mp4.", check=named(*FRAMES))
@click.option(
    "--views",
    callback=_views,
    default="front,three-quarter,profile",
    metavar="NAMES",
    help=f"Look from these sides, with commas between them: {', '.join(VIEWS)}; or turn once: {TURN}.",
)
@click.option(
    "--frames",
    type=WholeRange(1, 360),
    metavar="N",
    help=f"Draw N pictures of a turn, in a film {FPS} a second.  [default: "
    + ", ".join(f"{count} as {suffix}" for suffix, count in FRAMES.items())
    + "]",
)
@click.option("--size", type=WholeRange(16, 4096), default=512, metavar="PIXELS", help="Draw views this wide and high.")
@click.option(
    "--columns",
    type=WholeRange(1),
    metavar="N",
    help="Put N pictures into a row of the sheet: faces, or with one face its views.  [default: near to a square; "
    "the views of one face in one row]",
)
@click.option(
    "--image",
    type=PATH,
    metavar="IMAGE",
    help="Draw the face over this picture instead of the views, as large; the face must be an NPZ with a camera.",
)
@head_options
@overwrite_option
def command(paths, out, views, frames, size, columns, image, head, overwrite):
    """Draw shaded pictures of faces, meshes and rigs: views side by side, a turn, or an overlay.

    Faces and rigs are NPZ, GLB or glTF, meshes also OBJ, PLY or STL. They are drawn in the pictures that they wear (of
    those in a GLB the first, and that of a material named eyes), rigs with their neutral face, overlays in clay.
    Several become a contact sheet with the names of their files, or with what of their paths tells files of one name
    apart. Heads of the bundled topology get eyes, teeth, tongue and lashes where they are skin alone.

    \b
    Example:
      caricli render face.npz -o views.png
      caricli render rig.glb -o turn.mp4 --views turntable
      caricli render rig.glb -o turn.png --views turntable --frames 12 --size 256
      caricli render faces/*.obj -o sheet.png --views front --size 256
      caricli render face.npz -o overlay.png --image drawing.png
    """
    from caricli.render.sheets.face_sheet import SheetSettings

    film = out.suffix.lower() != ".png"
    _check_use(len(paths), film, views, frames, image)
    turn = (frames or FRAMES[out.suffix.lower()]) if views == (TURN,) else None
    settings = SheetSettings(views, turn, size, columns, "eyes" in head.parts)
    _check_size(out, len(paths) * (1 if film else settings.count), size)
    with staged(out, overwrite=overwrite, inputs=(*paths, image)) as (temporary,):
        if image is None:
            faces = [_whole(path, head) for path in paths]
            width, height = _draw(temporary, faces, _labels(paths), settings)
        else:
            picture = _overlay(read_face(paths[0]), paths[0], head, image)
            write_png(temporary, picture)
            height, width, _ = picture.shape
    echo_result(f"{shown(out)}: {width} x {height} pixels, faces: {len(paths)}")


def _labels(paths):
    """What tells files apart, their suffixes, too, where nothing else does."""
    names = distinct_names(paths)
    return (
        names
        if len(set(names)) == len(names)
        else [name + path.suffix for name, path in zip(names, paths, strict=True)]
    )


def _whole(path, head):
    """The face of a file as a head of the parts that are chosen."""
    from caricli.methods.parts.whole_head import whole_face
    from caricli.store.rig_sources import load_shown_face

    face = load_shown_face(path)
    with naming(path):
        return whole_face(face, head)


def _check_use(count, film, views, frames, image):
    """Refuse options that do not go together."""
    if image is not None:
        message = "--image takes one FACE and gives one picture, as .png, as large as IMAGE is."
        refuse_typed(message, "views", "size", "columns")
        if count > 1 or film:
            raise click.UsageError(message)
    if views != (TURN,) and (film or frames is not None):
        raise click.UsageError(f"A film and --frames are for --views {TURN}.")


def _draw(path, faces, names, settings):
    """Write a sheet, or a film where the name of the file says so; returns its width and height."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.io.video import write_video
    from caricli.render.sheets.face_sheet import face_sheet, turning_faces

    with progress_bar("pictures") as report:
        if path.suffix.lower() == ".png":
            picture = face_sheet(faces, names, settings)
            write_png(path, picture)
            return picture.shape[1], picture.shape[0]
        return write_video(path, turning_faces(faces, names, settings, report), FPS)


def _check_size(out, pictures, size):
    """Refuse a sheet that no reader would take."""
    if pictures * size * size > MAX_IMAGE_PIXELS:
        raise UsageError(
            f"{shown(out)}: {pictures} pictures of {size} x {size} are more than {MAX_IMAGE_PIXELS} pixels "
            "together; give a smaller --size"
        )


def _overlay(face, path, head, image):
    """The face as a head of the parts that are chosen, in clay over its picture."""
    from caricli.methods.parts.whole_head import whole_face
    from caricli.render.face_look import face_look
    from caricli.render.sheets.overlay import overlay_mesh

    if face.camera is None:
        raise InputError(f"{shown(path)}: expected a face NPZ with a camera to lay it over a picture, found none")
    with naming(path):
        plain = replace(whole_face(face, head), pictures=Pictures())
    return overlay_mesh(read_image(image), plain.mesh, face.camera, look=face_look(plain, "eyes" in head.parts))
