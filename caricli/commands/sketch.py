"""caricli sketch: the lines of a face."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import PATH, WholeRange, model_option, named, out_option, overwrite_option
from caricli.errors import shown
from caricli.io.outputs import staged
from caricli.io.parse_number import parse_number

_FARTHEST = 90.0
"""Degrees of yaw and pitch."""


def _view(ctx, param, value):
    try:
        yaw, pitch = (parse_number(word) for word in value.split(","))
    except ValueError:
        raise click.BadParameter(f"{value!r} is not YAW,PITCH in degrees, such as 30,0.") from None
    if max(abs(yaw), abs(pitch)) > _FARTHEST:
        raise click.BadParameter(f"{value!r} is not from {-_FARTHEST:g} to {_FARTHEST:g} degrees.")
    return yaw, pitch


@click.command()
@click.argument("face", type=PATH)
@out_option("SKETCH", "Write the lines here, as .svg, .json or .png.", check=named(".svg", ".json", ".png"))
@click.option(
    "--view",
    callback=_view,
    default="0,0",
    metavar="YAW,PITCH",
    help="Turn the head by so many degrees: YAW to the right of the picture, PITCH down; negative ones the other way.",
)
@click.option("--size", type=WholeRange(16, 4096), default=256, metavar="PIXELS", help="Make the canvas this wide.")
@click.option("--wrinkles/--no-wrinkles", default=True, help="Draw the lines between the features, too.")
@model_option
@overwrite_option
def command(face, out, view, size, wrinkles, model, overwrite):
    """Draw a face as lines: silhouette, features and wrinkles, with the names of the curves.

    FACE is NPZ, OBJ, PLY, GLB or glTF in the topology of a model. Silhouette and features are the curves that its
    annotation names, wrinkles are suggestive contours. In a view from aside hidden lines are left out, and the
    silhouette is the outline that is seen.

    \b
    Example:
      caricli sketch face.npz --out sketch.svg
      caricli sketch face.npz --out sketch.png --view 35,0 --size 512
    """
    from caricli.methods.sketch.sketch_artist import SketchArtist
    from caricli.store.faces import load_face
    from caricli.store.models import load_model
    from caricli.store.sketches import write_drawing

    with staged(out, overwrite=overwrite, inputs=(face, model)) as (temporary,):
        shape_model = load_model(model)
        vertices = load_face(face, shape_model).vertices
        artist = SketchArtist(shape_model.template)
        sketch = artist.draw(vertices, artist.camera(vertices, view, size), (size, size), wrinkles)
        write_drawing(temporary, sketch)
    echo_result(f"{shown(out)}: {len(sketch.strokes)} strokes, {size} x {size} pixels")
