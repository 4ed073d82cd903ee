"""caricli dataset pictures: draw the people of a dataset."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import PATH, WholeRange, overwrite_option, seed_option, workers_option
from caricli.io.outputs import staged_folder


@click.command()
@click.argument("dataset", type=PATH)
@click.argument("out", type=PATH, metavar="OUT_DIR")
@click.option("--count", type=WholeRange(1, 1_000_000), default=2000, metavar="N", help="Draw N pictures.")
@click.option(
    "--size", type=WholeRange(64, 1024), default=256, metavar="PIXELS", help="Make the pictures this wide and high."
)
@click.option("--model", type=PATH, help="Write the coefficients of this morphable model; else of the bundled one.")
@seed_option
@workers_option
@overwrite_option
def command(dataset, out, count, size, model, seed, workers, overwrite):
    """Draw pictures of a dataset's people with all that is known of them, to train and to measure networks with.

    People wear hair, hats, glasses and beards, stand in any light before any background, and are photographed,
    painted, inked, hatched, drawn in pencil or flat colours, or printed; some pictures show several, some nobody.
    OUT_DIR gets pictures/, labels/ (what every pixel shows), truth.npz (landmarks and which are seen, camera, light,
    coefficients: a row for every face) and pictures.json.

    \b
    Example:
      caricli dataset pictures people pictures --count 2000
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.dataset import read_dataset
    from caricli.data.picture_set import MANIFEST, PictureWriter
    from caricli.methods.pictures.build_pictures import PictureSettings, build_pictures
    from caricli.store.models import check_topology, load_morphable

    people = read_dataset(dataset)
    morphable = load_morphable(model)
    check_topology(morphable.template, people.template, model or "the bundled morphable model")
    settings = PictureSettings(count, size, seed)
    with (
        staged_folder(out, overwrite=overwrite, inputs=(dataset, model), marker=MANIFEST) as temporary,
        progress_bar("pictures") as report,
    ):
        summary = build_pictures(PictureWriter(temporary), people, morphable, settings, workers, report)
    echo_result(f"{out}: {summary['pictures']} pictures of {summary['faces']} faces")
