"""caricli evaluate blendshapes: how near the expressions of caricatures come to true ones, method by method."""

from dataclasses import replace
from typing import Any

import click
import numpy as np

from caricli.commands.shared.options import PATH, data_option, out_option, overwrite_option, seed_option
from caricli.commands.shared.tables import number, print_table
from caricli.errors import naming
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

SIZE = 224
"""Pixels of one picture on the sheet."""

SHOWN = ("laugh", "surprise", "closed_eyes", "pucker", "caricature_disdain", "caricature_furious")
"""Expressions on the sheet."""

_COLUMNS = {
    "error": ("error %", 3), "drift": ("drift %", 3), "strength": ("strength", 3), "excess": ("excess %", 1),
    "structure": ("structure", 3), "flipped": ("flips %", 3), "seconds": ("s", 2),
}  # fmt: skip


@click.command()
@data_option
@out_option("DIR", "A folder for blendshapes.json, every figure, and blendshapes.png.")
@click.option("--count", type=click.IntRange(1, 10_000), default=50, metavar="N", help="Caricatures to measure.")
@click.option("--everyone", is_flag=True, help="Not only test people: for a dataset that no model was trained on.")
@click.option("--given", type=click.Choice(["neutral", "any"]), default="neutral", help="What their pictures show.")
@click.option("--face", "faces", type=PATH, multiple=True, metavar="FACE.npz", help="Draw these, too; repeat.")
@seed_option
@overwrite_option
def command(dataset, out, count, everyone, given, faces, seed, overwrite):
    """Build the expressions of caricatures by every method, and compare them with the true ones.

    The dataset is a full grid, without --count, so that it has the same caricature with every expression. Each is seen
    once, in a random pose. Errors are mean distances to the true shapes in percent of the head's height. Drift is how
    far a caricature moves where the normal face hardly does, which changes who it is; strength, how far where that one
    moves clearly, as a share of its way; excess, how much farther on average; structure, how much the cosines between
    expressions differ from the normal face's. With --face the methods are drawn on real drawings, too.

    \b
    Example:
      caricli evaluate blendshapes --data grid --out expressions
      caricli evaluate blendshapes --data grid --everyone --given any --face drawing.npz --out expressions
    """
    from caricli.data.dataset import read_dataset
    from caricli.methods.evaluate.evaluate_blendshapes import dataset_caricatures, dataset_expressions
    from caricli.render.contact_sheet import contact_sheet
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
            caricatures = dataset_caricatures(data, everyone, count)
        drawings = {path.stem: load_caricature(path, tools) for path in faces}
        tally, rows = _evaluate(caricatures, tools, given, seed)
        rows += [row for name, (face, pictures) in drawings.items() for row in _drawn(name, face, pictures, tools)]
        recipe = provenance("evaluate blendshapes", [dataset / "dataset.json", *faces], seed, given=given)
        write_json(folder / "blendshapes.json", recipe | tally.summary)
        labels = [label for name, _ in rows for label in (name, *SHOWN)]
        cells = [picture for _, pictures in rows for picture in pictures]
        write_png(folder / "blendshapes.png", contact_sheet(cells, 1 + len(SHOWN), labels))
    _print(tally)


def _evaluate(caricatures: list, tools: Any, given: str, seed: int) -> tuple[Any, list]:
    """The ComparisonTally of caricatures, and the rows of the sheet that show one of them."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.evaluate.evaluate_blendshapes import ComparisonTally, evaluate_blendshapes

    tally = ComparisonTally([*tools.expressions])
    rows: list = []
    most = max(caricature.level for caricature in caricatures)
    with progress_bar("building blendshapes") as report:
        for caricature, comparison in evaluate_blendshapes(caricatures, tools, given, seed, report):
            tally.add(caricature, comparison)
            # One is enough to see, the most exaggerated of somebody.
            if not rows and caricature.level == most:
                built = comparison.blendshapes
                rows = [(name, _row(own, comparison.face, None, tools)) for name, own in built.items()]
    return tally, rows


def _drawn(name: str, face: Any, pictures: Any, tools: Any) -> list[tuple[str, list[np.ndarray]]]:
    """The rows of a real caricature, one for every method, with their names."""
    from caricli.methods.expressions.build_blendshapes import build_blendshapes
    from caricli.methods.expressions.settings import METHODS, BlendshapeSettings

    built = {f"{name}: {method}": build_blendshapes(face, tools, BlendshapeSettings(method)) for method in METHODS}
    return [(label, _row(own, face, pictures.load(), tools)) for label, own in built.items()]


def _row(blendshapes: Any, face: Any, pictures: Any, tools: Any) -> list[np.ndarray]:
    """Pictures of a face as it was given and with some of its expressions."""
    from caricli.methods.expressions.rig_blendshapes import rig_blendshapes, shape_as_given
    from caricli.methods.rig.make_rig import Pictures, RigSettings
    from caricli.render.expression_row import expression_row

    rig = rig_blendshapes(blendshapes, tools, RigSettings(), pictures or Pictures()).rig
    return expression_row(rig, shape_as_given(rig, face), SHOWN, SIZE)


def _print(tally: Any) -> None:
    """Print a ComparisonTally: means by method, then errors by expression."""
    means = tally.means
    rows = [
        (name, *(number(row.get(key), digits) for key, (_, digits) in _COLUMNS.items())) for name, row in means.items()
    ]
    titles = ("method", *(title for title, _ in _COLUMNS.values()))
    print_table(titles, rows, f"{len(tally.caricatures)} caricatures")
    rivals = [name for name in means if name != "truth"]
    rows = [
        (name, *(number(row[rival], 3) for rival in rivals), f"{row['full_is_nearest_on']} of {row['of']}")
        for name, row in tally.by_expression.items()
        if row["of"]
    ]
    print_table(("error % of", *rivals, "full nearest"), rows, "expressions")
