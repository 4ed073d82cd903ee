"""caricli dataset sketches: draw the people of a dataset as lines."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    WholeRange,
    overwrite_option,
    seed_option,
    workers_option,
)
from caricli.io.outputs import staged_folder


@click.command()
@click.argument("dataset", type=PATH)
@click.argument("out", type=PATH, metavar="OUT_DIR")
@click.option(
    "--count",
    type=WholeRange(1, 1_000_000),
    metavar="N",
    help="Draw N sketches.  [default: one of every mesh]",
)
@click.option(
    "--size", type=WholeRange(32, 1024), default=256, metavar="PIXELS", help="Make the canvases this wide and high."
)
@click.option(
    "--hand",
    type=FiniteRange(0, 2),
    default=1.0,
    metavar="NUMBER",
    help="Draw so carelessly: 0 gives the exact lines from the front, 1 what people draw.",
)
@seed_option
@workers_option
@overwrite_option
def command(dataset, out, count, size, hand, seed, workers, overwrite):
    """Draw sketches of a dataset's meshes with all that is known of them, to train networks with.

    Lines are the silhouette, the features and the wrinkles (suggestive contours), drawn as many hands would: turned a
    little, off the middle, with lines left out, bent, overshot, broken or doubled, with pressure and some width.
    OUT_DIR gets pictures/, strokes-*.npz (the lines, camera, person, expression, level) and sketches.json.

    \b
    Example:
      caricli dataset sketches people sketches --seed 1
    """
    from functools import partial

    from caricli.commands.shared.progress import progress_bar
    from caricli.data.dataset import read_dataset
    from caricli.data.sketch_set import MANIFEST, SketchWriter
    from caricli.methods.sketch.build_sketches import SketchSettings, build_sketches

    people = read_dataset(dataset)
    settings = SketchSettings(count or len(people.vertices), size, hand, seed)
    with (
        staged_folder(out, overwrite=overwrite, inputs=(dataset,), marker=MANIFEST) as temporary,
        progress_bar("sketches") as report,
    ):
        summary = build_sketches(partial(SketchWriter, temporary), people, settings, workers, report)
    echo_result(f"{out}: {summary['sketches']} sketches of {summary['strokes']:.1f} strokes in the mean")
