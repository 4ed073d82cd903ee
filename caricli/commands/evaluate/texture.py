"""caricli evaluate texture: textures of other expressions beside the true ones."""

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import PATH, WholeRange, out_option, overwrite_option, seed_option
from caricli.commands.shared.tables import print_table
from caricli.errors import shown
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

REGIONS = ("attention", "outside", "mouth", "opens")

ROWS = 8
"""Pairs on the sheet."""


@click.command()
@click.argument("networks", nargs=-1, type=PATH, metavar="NETWORK...")
@click.option(
    "--data",
    "folder",
    type=PATH,
    metavar="DIR",
    required=True,
    help="Let rivals learn from, and test on, the splits of this folder of `caricli dataset textures`.",
)
@click.option(
    "--people",
    type=PATH,
    metavar="DIR",
    help="Test on everybody of this folder of `caricli dataset textures`.  [default: the test split of --data]",
)
@click.option(
    "--styles",
    type=PATH,
    metavar="DIR",
    help="Test people painted in the styles of the drawings in this folder, too.  [default: generated styles]",
)
@out_option("DIR", "Write texture.json, with every figure, and texture.png into this folder.")
@click.option("--count", type=WholeRange(1, 100_000), default=400, metavar="N", help="Test so many pairs.")
@seed_option
@overwrite_option
def command(networks, folder, people, styles, out, count, seed, overwrite):
    """Compare textures that networks paint for other expressions with the true ones.

    NETWORK is what `caricli train texture` wrote; without one the bundled network is measured. Differences are means of
    sRGB from 0 to 1, in percent of those of the texture that is kept as it is: where the face moves most (attention),
    in the rest of the skin, in open mouths, and in those that were closed before; from people drawn anew 2,000 times
    comes what 95 % of the figures lie between. Expressions are read by a network that knows true textures only. The
    rival "linear" changes textures by what is linear in the difference of the expressions, "spline" warps the picture
    from landmarks to landmarks. Flicker is how much textures turn back from frame to frame of a take from the neutral
    face, in percent of how much they change over two frames.

    \b
    Example:
      caricli evaluate texture run/model.safetensors --data textures --out evaluated
      caricli evaluate texture --data textures --people others --out evaluated
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.store.styles import load_style_book
    from caricli.store.texture_run import TextureFolders, load_texture_test, texture_sources

    sources = texture_sources([folder, *([people] if people else [])], None, styles)
    with staged_folder(out, overwrite=overwrite, inputs=(*networks, *sources), marker="texture.json") as target:
        book, notes = load_style_book(styles, seed)
        with progress_bar("painting") as report:
            test = load_texture_test(networks, TextureFolders(folder, people), book, seed, report)
        with progress_bar("comparing") as report:
            tally = test.run(count, seed, report)
        about = provenance("evaluate texture", [*networks, *sources], seed, count=count)
        figures = {
            "people": tally.people,
            "painters": tally.figures(seed),
            "reading": tally.reading,
            "flicker": test.flicker(),
        }
        write_json(target / "texture.json", about | figures)
        write_png(target / "texture.png", test.sheet(ROWS, seed))
    echo_notes(*(f"caricli: {note}" for note in notes))
    _print(figures)
    echo_result(f"{shown(out)}: {count} pairs of {tally.people} people")


def _print(figures: dict) -> None:
    """Print painters with their figures."""
    rows = [
        (name, *(_cell(table[region]) for region in REGIONS), f"{figures['reading'][name]:.3f}", _steady(figures, name))
        for name, table in figures["painters"].items()
    ]
    true = ("true", *"----", f"{figures['reading']['true']:.3f}", "-")
    print_table(("% of kept", *REGIONS, "read", "flicker %"), [*rows, true])


def _steady(figures: dict, name: str) -> str:
    """Of a painter; the texture that is kept does not change."""
    return f"{figures['flicker'][name]:.1f}" if name in figures["flicker"] else "-"


def _cell(figure: dict) -> str:
    """Of a region; "-" for one that no face shows."""
    if figure["percent"] is None:
        return "-"
    return f"{figure['percent']:.0f} ({figure['low']:.0f} to {figure['high']:.0f})"
