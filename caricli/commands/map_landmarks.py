"""caricli map-landmarks: landmarks of a caricature to those of a normal face, or back."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import PATH, WholeRange, out_option, overwrite_option, pts_origin_option
from caricli.errors import naming
from caricli.io.image import write_png
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.io.outputs import staged
from caricli.structures import Landmarks
from caricli.structures.landmarks import COUNT

SIZE = 512


@click.command()
@click.argument("landmarks", type=PATH, metavar="LANDMARKS")
@click.option(
    "--to",
    type=click.Choice(["normal", "caricature"]),
    required=True,
    help="Turn the landmarks into those of such a face.",
)
@out_option("MAPPED.json", "Write the landmarks here; MAPPED.png, a drawing of both, goes beside it.", suffix=".json")
@click.option(
    "--map",
    "map_path",
    type=PATH,
    metavar="MAP",
    help="Use this map of `caricli train landmark-map`.  [default: bundled]",
)
@click.option(
    "--style-seed",
    type=WholeRange(0, 2**32 - 1),
    metavar="SEED",
    help="Draw one of the many caricatures of a face by this seed.  [default: the likeliest]",
)
@pts_origin_option
@overwrite_option
def command(landmarks, to, out, map_path, style_seed, pts_origin, overwrite):
    """Map 68 landmarks (iBUG) of a caricature to those of a normal face, or of a normal face to a caricature's.

    Eyes and mouth keep their place in the picture. Of 81 landmarks the first 68 are mapped. All of them must be known.
    A caricature has one normal face, a normal face many caricatures: the likeliest is hardly exaggerated, --style-seed
    draws stronger ones.

    \b
    Example:
      caricli map-landmarks drawing.json --to normal --out normal.json
      caricli map-landmarks normal.json --to caricature --style-seed 3 --out another.json
    """
    from caricli.methods.edit.map_landmarks import map_landmarks, mean_shift
    from caricli.models.landmark_map.model import other
    from caricli.render.sheets.landmark_pair import landmark_pair
    from caricli.store.landmark_maps import landmark_map_path, load_landmark_map

    _check_usage(to, style_seed)
    map_path = landmark_map_path(map_path)
    with staged(out, out.with_suffix(".png"), overwrite=overwrite, inputs=(landmarks, map_path)) as files:
        landmark_map = load_landmark_map(map_path)
        marks = read_landmarks(landmarks, pts_origin)
        with naming(landmarks):
            points = marks.head_points
            mapped = map_landmarks(points, landmark_map, to, _style(landmark_map, style_seed))
            turned = Landmarks(mapped, marks.image_size)
        write_landmarks(files[0], turned)
        write_png(files[1], landmark_pair({other(to): points[:COUNT], to: mapped}, SIZE))
    left_out = "" if len(points) == COUNT else f" (the first of {len(points)})"
    share = mean_shift(points, mapped)
    echo_result(f"{out}: {COUNT} landmarks{left_out} to {to}, moved by {share:.2f} % of their diagonal")


def _check_usage(to, style_seed):
    """Refuse a style for normal faces, which have none."""
    if to == "normal" and style_seed is not None:
        raise click.UsageError("--style-seed is for --to caricature: a caricature has one normal face.")


def _style(landmark_map, seed):
    """The style of a LandmarkMap that a seed draws, or None for the likeliest."""
    import numpy as np

    return None if seed is None else landmark_map.draw_styles(np.random.default_rng(seed), 1)[0]
