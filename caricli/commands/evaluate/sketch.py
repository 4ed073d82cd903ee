"""caricli evaluate sketch: faces from sketches beside the true ones."""

from pathlib import Path
from typing import Any

import click
import numpy as np

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import PATH, WholeRange, data_option, out_option, overwrite_option, seed_option
from caricli.errors import naming, shown
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

OTHERS = 60
"""Faces of the validation split on which the noise of the fits is chosen, at most."""


@click.command()
@data_option
@click.option("--network", type=PATH, metavar="FILE", help="Measure this network.  [default: caricli's]")
@click.option("--model", type=PATH, metavar="MODEL", help="The model whose latents it tells.  [default: pca]")
@out_option("DIR", "Write sketch.json, errors.png and strokes.png into this folder.")
@click.option("--count", type=WholeRange(1, 10**6), default=500, metavar="N", help="Measure at most N faces.")
@click.option(
    "--everyone",
    is_flag=True,
    help="Take all people that network and model were not trained with, but for the validation split.",
)
@seed_option
@overwrite_option
def command(dataset, network, model, out, count, everyone, seed, overwrite):
    """Compare faces that a network sees in sketches with the true ones, beside a fit of the linear model to the lines.

    Sketches are drawn of the dataset's test people: clean; with the noise of view and hand; and with noise and without
    half of the strokes. Errors are mean distances of vertices in mm where the face is 200 mm high, without alignment
    (sketch paper, table 2). How much the fits trust the lines is chosen on people of the validation split. errors.png
    shows where errors are, strokes.png how they grow as strokes are left out.

    \b
    Example:
      caricli evaluate sketch --data people --out figures
      caricli evaluate sketch --data people --network run/model.safetensors --everyone --out figures
    """
    from caricli.commands.shared.tables import print_table
    from caricli.methods.evaluate.evaluate_sketch import CONDITIONS, rows
    from caricli.render.error_maps import error_maps
    from caricli.store.datasets import dataset_files

    inputs = [*dataset_files(dataset), network, model]
    with staged_folder(out, overwrite=overwrite, inputs=(dataset, *inputs), marker="sketch.json") as folder:
        rivals, unseen = _rivals(dataset, network, model, everyone)
        figures, faces = _evaluate(rivals, unseen.data, count, seed)
        recipe = provenance("evaluate sketch", [dataset / "dataset.json", network, model], seed)
        write_json(folder / "sketch.json", recipe | unseen.figures | {"faces": faces} | figures.as_json())
        write_png(folder / "errors.png", error_maps(rivals.model.template, figures.maps))
        write_png(folder / "strokes.png", _strokes(figures, len(rivals.network.curves)))
    echo_notes(unseen.note)
    print_table(("mm", *CONDITIONS), rows(figures.errors), f"{faces} faces of {unseen.test} people")
    echo_result(f"{shown(out)}: {figures.errors['network']['noise']:.2f} mm with noise")


def _rivals(dataset: Path, network: Path | None, model: Path | None, everyone: bool) -> tuple[Any, Any]:
    """SketchRivals, and the UnseenData of a dataset."""
    from caricli.data.dataset import read_dataset
    from caricli.data.unseen import unseen_data
    from caricli.methods.evaluate.evaluate_sketch import SketchRivals
    from caricli.store.models import check_topology
    from caricli.store.sketch_networks import load_sketch_pair
    from caricli.structures import SeenPeople
    from caricli.template.feature_curves import feature_curves

    data = read_dataset(dataset)
    own, basis = load_sketch_pair(network, model)
    check_topology(basis.template, data.template, "the model of the network")
    seen = {"the network": SeenPeople.of_recipe(own.recipe), "its model": basis.seen}
    with naming(dataset):
        unseen = unseen_data(_with_everyone(data) if everyone else data, seen)
    return SketchRivals.of(own, basis, feature_curves(basis.template.annotation)), unseen


def _with_everyone(data: Any) -> Any:
    """A Dataset whose training people are tested with, too."""
    from dataclasses import replace

    splits = data.manifest["splits"]
    both = {"train": [], "validation": splits["validation"], "test": sorted(splits["train"] + splits["test"])}
    return replace(data, manifest=data.manifest | {"splits": both})


def _evaluate(rivals: Any, data: Any, count: int, seed: int) -> tuple[Any, int]:
    """SketchFigures, and of how many faces."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.evaluate.evaluate_shape import split_rows
    from caricli.methods.evaluate.evaluate_sketch import evaluate_sketch

    tested = data.vertices[split_rows(data, "test", 1, count)].astype(np.float64)
    others = data.vertices[split_rows(data, "validation", 0, min(count, OTHERS))].astype(np.float64)
    with progress_bar("measuring") as report:
        return evaluate_sketch(rivals, tested, others, seed, report), len(tested)


def _strokes(figures: Any, curves: int) -> np.ndarray:
    """The errors over the strokes that are left, as a picture."""
    from caricli.render.plot_curves import plot_curves

    left = sorted(figures.left)
    lines = {"network": ([round(curves * share) for share in left], [figures.left[share] for share in left])}
    return plot_curves({"as strokes are left out": lines}, "strokes left", "mm, face 200 mm high, with noise")
