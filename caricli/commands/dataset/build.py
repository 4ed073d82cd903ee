"""caricli dataset build: generate caricatures."""

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    WholeRange,
    overwrite_option,
    refuse_typed,
    seed_option,
    workers_option,
)
from caricli.io.outputs import staged_folder


@click.command()
@click.argument("out", type=PATH, metavar="OUT_DIR")
@click.option("--count", type=WholeRange(1), metavar="N", help="Draw N meshes at random instead of the full grid.")
@click.option("--identities", type=WholeRange(1, 100_000), default=150, metavar="N", help="Make N people.")
@click.option("--expressions", type=WholeRange(1, 25), default=25, metavar="N", help="Use N expressions.")
@click.option(
    "--levels",
    type=WholeRange(1, 4),
    default=4,
    metavar="N",
    help="Make N levels of exaggeration; with 1 there is none.",
)
@click.option(
    "--own",
    is_flag=True,
    help="Exaggerate in the draws of --count what is each person's own, alone and with parts.",
)
@click.option(
    "--albedo",
    "albedos",
    type=WholeRange(0),
    default=0,
    metavar="N",
    help="Draw N pictures of random colours, too.",
)
@click.option(
    "--albedo-size",
    type=WholeRange(32, 4096),
    default=256,
    metavar="TEXELS",
    help="Make the pictures of --albedo this wide and high.",
)
@seed_option
@workers_option
@overwrite_option
def command(out, count, identities, expressions, levels, own, albedos, albedo_size, seed, workers, overwrite):
    """Generate a dataset of faces and caricatures from the open head.

    Without --count it is the full grid of people, expressions and levels of curvature exaggeration; with it the meshes
    are random draws: regular faces, and faces exaggerated by curvature, by parts, and by both. With --own what stands
    out in a person is exaggerated instead, alone or before parts: place by place and more than in proportion, at the
    cost of what lies around it, and unlike on both sides. With --albedo the folder also holds pictures of skin, lips,
    brows and hair in the UVs of the head, for any of the faces.

    Datasets of one --seed share people: the first ones are the same, in other splits. What was trained on one is tested
    on one of another seed.

    \b
    Example:
      caricli dataset build dataset --count 1409
      caricli dataset build grid --identities 150 --expressions 25 --levels 4
      caricli dataset build own --count 4000 --identities 800 --own
      caricli dataset build regular --count 4000 --identities 800 --levels 1
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.build_dataset import build_dataset
    from caricli.data.build_settings import BuildSettings, OwnSettings
    from caricli.data.dataset import MANIFEST

    if own and count is None:
        raise click.UsageError("--own is for --count.")
    if not albedos:
        refuse_typed("--albedo-size is of the pictures of --albedo.", "albedo_size")
    settings = (OwnSettings if own else BuildSettings)(count, identities, expressions, levels, seed)
    with staged_folder(out, overwrite=overwrite, marker=MANIFEST) as temporary, progress_bar("meshes") as report:
        summary = build_dataset(temporary, settings, workers, report, albedos, albedo_size)
    echo_result(f"{out}: {summary['meshes']} meshes, flipped triangles {100 * summary['flipped']:.3f} %")
