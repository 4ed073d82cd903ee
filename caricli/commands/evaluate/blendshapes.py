"""caricli evaluate blendshapes: how near the expressions of caricatures come to true ones, method by method."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import PATH, WholeRange, data_option, out_option, overwrite_option, seed_option
from caricli.commands.shared.tables import number, print_table
from caricli.errors import naming, shown
from caricli.io.distinct_names import distinct_names
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

SIZE = 224
"""Pixels of one picture on the sheet."""

SHOWN = ("laugh", "surprise", "closed_eyes", "pucker", "caricature_disdain", "caricature_furious")
"""Expressions on the sheet."""

_COLUMNS = {
    "error": ("error %", 3), "drift": ("drift %", 3), "drift_off": ("off %", 3), "strength": ("strength", 3),
    "strength_off": ("off", 3), "excess": ("excess %", 1), "structure": ("structure", 3),
    "flipped": ("flips %", 3), "seconds": ("s", 2),
}  # fmt: skip


@click.command()
@data_option
@out_option("DIR", "Write blendshapes.json, with every figure, and blendshapes.png into this folder.")
@click.option("--count", type=WholeRange(1, 10_000), default=50, metavar="N", help="Measure at most N caricatures.")
@click.option(
    "--everyone",
    is_flag=True,
    help="Take all people that the models were not trained with, not only those of the test split.",
)
@click.option(
    "--given",
    type=click.Choice(["neutral", "any"]),
    default="neutral",
    help="Let the pictures show the neutral expression, or any of them.",
)
@click.option(
    "--face", "faces", type=PATH, multiple=True, metavar="FACE.npz", help="Draw this face, too; repeat for more."
)
@seed_option
@overwrite_option
def command(dataset, out, count, everyone, given, faces, seed, overwrite):
    """Build the expressions of caricatures by every method, and compare them with the true ones.

    The dataset is a full grid, without --count, so that it has the same caricature with every expression. Each is seen
    once, in a random pose. Errors are mean distances to the true shapes in percent of the head's height. Drift is how
    far scalp, ears and temples move, which no expression is meant to; strength, how far the face goes where a normal
    one moves clearly, as a share of its way; beside both stands how far they are from the truth's. Excess is how much
    farther than the normal face on average; structure, how much the cosines between expressions differ from its.
    Differences are paired over caricatures; their intervals hold 95 % of what draws of the people give. With --face the
    methods are drawn on real drawings, too. Nobody is measured whom one of the models was trained with: build the
    dataset with another --seed.

    \b
    Example:
      caricli evaluate blendshapes --data grid --out expressions
      caricli evaluate blendshapes --data grid --everyone --given any --face drawing.npz --out expressions
    """
    from caricli.data.dataset import MANIFEST, read_dataset
    from caricli.data.unseen import unseen_data
    from caricli.methods.evaluate.blendshape_sheet import BlendshapeSheet
    from caricli.methods.evaluate.evaluate_blendshapes import dataset_caricatures, dataset_expressions
    from caricli.store.datasets import dataset_files
    from caricli.store.expression_tools import load_caricature, load_tools
    from caricli.store.models import check_topology

    inputs = [dataset, *dataset_files(dataset), *faces]
    with staged_folder(out, overwrite=overwrite, inputs=inputs, marker="blendshapes.json") as folder:
        data = read_dataset(dataset)
        tools, _ = load_tools(latent=True)
        check_topology(tools.morphable.template, data.template, "the bundled morphable model")
        with naming(dataset):
            tools = replace(tools, expressions=dataset_expressions(data, tools.actions.names))
            unseen = unseen_data(data, tools.seen, everyone)
            caricatures = dataset_caricatures(unseen.data, count)
        drawings = [load_caricature(path, tools) for path in faces]
        sheet = BlendshapeSheet(tools, SHOWN, SIZE)
        tally = _evaluate(caricatures, given, seed, sheet)
        _add_drawings(sheet, distinct_names(faces), drawings)
        recipe = provenance("evaluate blendshapes", [dataset / MANIFEST, *faces], seed, given=given)
        write_json(folder / "blendshapes.json", recipe | unseen.figures | tally.summary)
        write_png(folder / "blendshapes.png", sheet.image)
    _print(out, tally, unseen.note)


def _evaluate(caricatures: list, given: str, seed: int, sheet: Any) -> Any:
    """The ComparisonTally of caricatures; one of them is drawn on a BlendshapeSheet."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.evaluate.evaluate_blendshapes import ComparisonTally, evaluate_blendshapes

    tally = ComparisonTally([*sheet.tools.expressions])
    most = max(caricature.level for caricature in caricatures)
    with progress_bar("building blendshapes") as report:
        for caricature, comparison in evaluate_blendshapes(caricatures, sheet.tools, given, seed, report):
            tally.add(caricature, comparison)
            # One is enough to see, the most exaggerated of somebody.
            if not sheet.cells and caricature.level == most:
                sheet.add_comparison(comparison)
    return tally


def _add_drawings(sheet: Any, names: list[str], drawings: list) -> None:
    """Add Caricatures to a BlendshapeSheet."""
    for name, caricature in zip(names, drawings, strict=True):
        sheet.add_face(name, caricature.face, caricature.worn.load())


def _print(out: Path, tally: Any, note: str | None) -> None:
    """Print a ComparisonTally: means by method, then errors by expression, and on stderr what else is to be said."""
    echo_notes(note)
    means = tally.means
    rows = [
        (name, *(number(row.get(key), digits) for key, (_, digits) in _COLUMNS.items())) for name, row in means.items()
    ]
    titles = ("method", *(title for title, _ in _COLUMNS.values()))
    print_table(titles, rows, f"{len(tally.caricatures)} caricatures")
    differences = ", ".join(f"{name} {_interval(own)}" for name, own in tally.differences.items())
    echo_notes(f"error of full less that of {differences}")
    rivals = [name for name in means if name != "truth"]
    rows = [
        (
            name,
            *(number(row[rival], 3) for rival in rivals),
            f"{row['full_is_nearest_on']} of {row['of']}",
            _interval(row["beside_transfer"]),
        )
        for name, row in tally.by_expression.items()
        if row["of"]
    ]
    print_table(("error % of", *rivals, "full nearest", "full less transfer"), rows, "expressions")
    echo_result(f"{shown(out)}: {len(tally.caricatures)} caricatures")


def _interval(difference: dict) -> str:
    """A paired difference with its interval."""
    return "{mean:+.3f} ({low:+.3f} to {high:+.3f})".format(**difference)
