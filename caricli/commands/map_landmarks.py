"""caricli map-landmarks: landmarks of a caricature to those of a normal face, or back."""

import click
import numpy as np

from caricli.commands.shared.options import PATH, out_option, overwrite_option
from caricli.errors import InputError, shown
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.io.outputs import staged
from caricli.structures import Landmarks

SIZE, MARGIN = 512, 0.15
_COLOURS = {"normal": (30, 110, 200), "caricature": (215, 40, 40)}


@click.command()
@click.argument("landmarks", type=PATH, metavar="LANDMARKS")
@click.option("--to", type=click.Choice(["normal", "caricature"]), required=True, help="What the result looks like.")
@out_option("MAPPED.json", "The mapped landmarks; MAPPED.png, a drawing of both, is written beside it.", suffix=".json")
@click.option("--map", "map_path", type=PATH, metavar="MAP", help="Of caricli train landmark-map.  [default: bundled]")
@click.option("--pts-origin", type=click.IntRange(0, 1), default=1, help="Coordinate of the first pixel in .pts files.")
@overwrite_option
def command(landmarks, to, out, map_path, pts_origin, overwrite):
    """Map 68 landmarks (iBUG) of a caricature to those of a normal face, or of a normal face to a caricature's.

    Eyes and mouth keep their place in the picture. Of 81 landmarks the first 68 are mapped. All of them must be known.

    \b
    Example:
      caricli map-landmarks drawing.json --to normal --out normal.json
      caricli map-landmarks normal.json --to caricature --out back.json --map map.safetensors
    """
    from caricli.io.bundled import asset_path
    from caricli.io.checkpoint import read_checkpoint
    from caricli.io.image import write_png
    from caricli.methods.edit.map_landmarks import map_landmarks
    from caricli.models.landmark_map.model import COUNT, map_from_checkpoint

    map_path = map_path or asset_path("landmark_map.safetensors")
    picture = out.with_suffix(".png")
    with staged(out, picture, overwrite=overwrite, inputs=(landmarks, map_path)) as files:
        landmark_map = map_from_checkpoint(*read_checkpoint(map_path), shown(map_path))
        marks = read_landmarks(landmarks, pts_origin)
        try:
            mapped = map_landmarks(marks.points, landmark_map, to)
        except InputError as error:
            raise InputError(f"{shown(landmarks)}: {error}") from error
        write_landmarks(files[0], Landmarks(mapped, marks.image_size))
        write_png(files[1], _drawing(marks.points[:COUNT], mapped, to))
    left_out = "" if len(marks.points) == COUNT else f" (the first of {len(marks.points)})"
    moved = np.linalg.norm(mapped - marks.points[:COUNT], axis=1).mean()
    share = 100 * moved / np.linalg.norm(np.ptp(marks.points[:COUNT], axis=0))
    click.echo(f"{out}: {COUNT} landmarks{left_out} to {to}, moved by {share:.2f} % of their diagonal")


def _drawing(given, mapped, to):
    """Given and mapped landmarks side by side, at one scale."""
    from caricli.models.landmark_map.model import other
    from caricli.render.contact_sheet import contact_sheet
    from caricli.render.overlay import draw_landmarks

    both = np.concatenate([given, mapped])
    low, extent = both.min(0), np.ptp(both, axis=0)
    zoom = SIZE * (1 - 2 * MARGIN) / extent.max()
    white = np.full((SIZE, SIZE, 3), 255, np.uint8)
    pictures = [
        draw_landmarks(white, (points - low - extent / 2) * zoom + SIZE / 2, _COLOURS[name])
        for name, points in ((other(to), given), (to, mapped))
    ]
    return contact_sheet(pictures, 2, [f"{other(to)}, given", f"{to}, mapped"])
