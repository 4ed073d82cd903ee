"""caricli evaluate portrait: coarse and refined faces of portraits side by side."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    WholeRange,
    data_option,
    out_option,
    overwrite_option,
    pts_origin_option,
    refuse_typed,
    seed_option,
)
from caricli.commands.shared.tables import number, print_table
from caricli.errors import naming, shown
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

SIZE = 512
"""Pixels of the rendered portraits."""

TEXTURE = 512
"""Texels of the textures."""

VIEW = 320
"""Pixels of one picture on the sheet."""

SHOWN = 6
"""Portraits of each set on the sheet."""

_PARTS = {"eyes": "eyes", "nose": "nose", "brows": "brow", "mouth": "mouth", "jaw": "contour", "all": "NME %"}
_REST = ("sum px", "colour %", "3D %", "flips %", "s")
_DIGITS = (*[2] * len(_PARTS), 1, 2, 2, 3, 2)


@click.command()
@data_option
@out_option("DIR", "Write portrait.json, with every figure of every face, and portrait.png into this folder.")
@click.option(
    "--count", type=WholeRange(1, 10_000), default=50, metavar="N", help="Render N test faces of the dataset."
)
@click.option(
    "--everyone",
    is_flag=True,
    help="Take all people that the models were not trained with, not only those of the test split.",
)
@click.option(
    "--noise",
    type=FiniteRange(0, 10),
    default=0.3,
    metavar="PERCENT",
    help="Displace rendered landmarks at random, with this standard deviation in percent of their diagonal.",
)
@click.option(
    "--pictures", type=PATH, metavar="DIR", help="Measure these pictures, too, with landmarks of the same names."
)
@pts_origin_option
@seed_option
@overwrite_option
def command(dataset, out, count, everyone, noise, pictures, pts_origin, seed, overwrite):
    """Reconstruct, refine and texture portraits by every method and compare the errors.

    The portraits are test faces of a dataset, rendered in random poses and colours, and real pictures if there are any.
    Landmark errors are in percent of the landmarks' diagonal; the photometric error is the mean difference of colour to
    the picture inside the head, of full scale; the 3D error is the mean distance of the face's vertices after alignment
    in percent of the head's height. Seconds are without the texture. Whom the models were trained with is left out of
    the test faces.

    \b
    Example:
      caricli evaluate portrait --data dataset --out portraits
      caricli evaluate portrait --data dataset --count 10 --pictures drawings --out portraits
    """
    from caricli.data.dataset import MANIFEST, read_dataset
    from caricli.data.unseen import unseen_data
    from caricli.methods.evaluate.evaluate_portrait import PICTURES, RENDERED, RenderedPortraits, RenderSettings
    from caricli.store.datasets import dataset_files
    from caricli.store.portraits import load_portrait, load_rivals

    pairs = _pairs(pictures)
    files = [path for pair in pairs for path in pair]
    inputs = (dataset, *dataset_files(dataset), pictures, *files)
    with staged_folder(out, overwrite=overwrite, inputs=inputs, marker="portrait.json") as folder:
        data = read_dataset(dataset)
        models = load_rivals(data.template)
        sets = {PICTURES: [load_portrait(*pair, pts_origin) for pair in pairs]}
        with naming(dataset):
            unseen = unseen_data(data, {kind: model.seen for kind, model in models.items()}, everyone)
            sets = {RENDERED: RenderedPortraits(unseen.data, RenderSettings(count, SIZE, noise, seed))} | sets
        tally, sheet = _evaluate(sets, models)
        recipe = provenance("evaluate portrait", [dataset / MANIFEST, *files], seed)
        about = {"noise": noise, "size": SIZE, "texture": TEXTURE}
        about["models"] = {kind: model.model_id for kind, model in models.items()}
        write_json(folder / "portrait.json", recipe | about | unseen.figures | tally.summary)
        write_png(folder / "portrait.png", sheet)
    echo_notes(unseen.note)
    _print(tally)
    echo_result(f"{shown(out)}: {sum(tally.count(group) for group in tally.means)} portraits")


def _pairs(pictures: Path | None) -> list[tuple[Path, Path]]:
    """Real pictures, each with its landmarks. Raises UsageError where their coordinates are told and there are none."""
    from caricli.store.portraits import portrait_files

    if pictures is None:
        refuse_typed("--pts-origin is of the landmarks of --pictures.", "pts_origin")
    return portrait_files(pictures)


def _evaluate(sets: dict, models: dict) -> tuple[Any, np.ndarray]:
    """The PortraitTally of sets of portraits, and a sheet with some of them."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.evaluate.evaluate_portrait import PortraitTally, evaluate_portraits
    from caricli.methods.evaluate.portrait_sheet import PortraitSheet

    tally = PortraitTally()
    sheet = PortraitSheet(models["intrinsic"].template, VIEW)
    with progress_bar("reconstructing portraits") as report:
        for group, result in evaluate_portraits(sets, models, TEXTURE, report):
            tally.add(group, result)
            if tally.count(group) <= SHOWN:
                sheet.add(result)
    return tally, sheet.image


def _print(tally: Any) -> None:
    """Print a PortraitTally."""
    for group, rivals in tally.means.items():
        rows = [(name, *map(number, _figures(row), _DIGITS)) for name, row in rivals.items()]
        print_table(("method", *_PARTS.values(), *_REST), rows, f"{tally.count(group)} {group}")
    for name, gain in tally.gains.items():
        change = f"{gain['before']:.3f} to {gain['after']:.3f} %, lower on {gain['better']} of {gain['faces']} faces"
        click.echo(f"refine takes the 3D error of {name} from {change}")
    for where, reason in tally.refused.items():
        echo_notes(f"refused: {where}: {reason}")


def _figures(row: dict) -> list[float | None]:
    """The columns of the table; what a method has no figure of is None."""
    parts = [row["nme"].get(part) for part in _PARTS]
    return [*parts, row["pixels"]["all"], row.get("photometric"), row.get("shape"), row["flipped"], row["seconds"]]
