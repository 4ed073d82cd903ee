"""caricli dataset textures: take the textures of people with many expressions."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import PATH, WholeRange, overwrite_option, seed_option, workers_option
from caricli.io.outputs import staged_folder


@click.command()
@click.argument("dataset", type=PATH)
@click.argument("out", type=PATH, metavar="OUT_DIR")
@click.option("--count", type=WholeRange(1, 100_000), default=100, metavar="N", help="Draw N people.")
@click.option(
    "--expressions", type=WholeRange(2, 100), default=20, metavar="N", help="Draw each with N, one of them neutral."
)
@click.option(
    "--size", type=WholeRange(16, 1024), default=128, metavar="TEXELS", help="Make the textures this wide and high."
)
@seed_option
@workers_option
@overwrite_option
def command(dataset, out, count, expressions, size, seed, workers, overwrite):
    """Take the textures of a dataset's people with many expressions, to train networks with.

    Every person is drawn in one light and pose with expressions of the dataset and blends of them: skin folds and
    reddens, as age and the person's own pattern have it, and lips part before teeth and tongue. From each picture the
    texture is taken as `caricli texture` does, and brought to the chart of the face. OUT_DIR gets shard-*.npz
    (textures, what of them was seen, weights of actions, shapes, person, level, age) and textures.json. DATASET must be
    one that was built.

    \b
    Example:
      caricli dataset textures people textures --count 100
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.dataset import read_dataset
    from caricli.data.texture_set import MANIFEST, TextureWriter
    from caricli.methods.creases.build_textures import TextureSetSettings, build_textures

    people = read_dataset(dataset)
    settings = TextureSetSettings(count, expressions, size, seed)
    with (
        staged_folder(out, overwrite=overwrite, inputs=(dataset,), marker=MANIFEST) as temporary,
        progress_bar("people") as report,
    ):
        summary = build_textures(TextureWriter(temporary), people, settings, workers, report)
    echo_result(f"{out}: {summary['people']} people, {100 * summary['seen']:.0f} % of their textures seen")
