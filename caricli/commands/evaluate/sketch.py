"""caricli evaluate sketch: faces from sketches beside the true ones."""

from pathlib import Path
from typing import Any

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import PATH, WholeRange, data_option, out_option, overwrite_option, seed_option
from caricli.errors import InputError, naming, shown
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder
from caricli.io.provenance import made_of, provenance
from caricli.io.strict_json import write_json

OTHERS = 60
"""Faces on which the noise of the fits is chosen, at most."""

SHOWN = 8
"""Faces of the gallery."""


@click.command()
@data_option
@click.option(
    "--network",
    "networks",
    type=PATH,
    metavar="FILE",
    multiple=True,
    help="Measure this network, and, repeated, others beside it.  [default: caricli's]",
)
@click.option(
    "--model",
    "models",
    type=PATH,
    metavar="MODEL",
    multiple=True,
    help="A model whose latents networks tell; repeat it.  [default: pca]",
)
@click.option(
    "--trained",
    type=PATH,
    metavar="DATASET",
    help="Also measure those faces of people of this dataset that the trainings held out.",
)
@out_option("DIR", "Write sketch.json, errors.png, strokes.png and gallery.png into this folder.")
@click.option("--count", type=WholeRange(1, 10**6), default=500, metavar="N", help="Measure at most N faces.")
@click.option(
    "--everyone",
    is_flag=True,
    help="Take all people that networks and models were not trained with, but for the validation split.",
)
@seed_option
@overwrite_option
def command(dataset, networks, models, trained, out, count, everyone, seed, overwrite):
    """Compare faces that networks see in sketches with the true ones, beside fits of a linear model to the lines.

    Sketches are drawn of the dataset's test people: clean; with the noise of view and hand; and with noise and without
    half of the strokes. Errors are mean distances of vertices in mm where the face is 200 mm high, without alignment
    (sketch paper, table 2). How much the fits trust the lines is chosen on people of the validation split. errors.png
    shows where errors are, strokes.png how they grow as strokes are left out, gallery.png sketches, what the first
    network makes of them, and the true faces. Published networks draw heads at their size, others fill the picture.

    \b
    Example:
      caricli evaluate sketch --data people --out figures
      caricli evaluate sketch --data people --network run/model.safetensors --everyone --out figures
    """
    from caricli.data.dataset import MANIFEST
    from caricli.methods.evaluate.evaluate_sketch import TENTH, UNSEEN
    from caricli.render.sheets.error_maps import error_maps
    from caricli.store.datasets import dataset_files

    inputs = [*dataset_files(dataset), *networks, *models, *(dataset_files(trained) if trained else [])]
    with staged_folder(out, overwrite=overwrite, inputs=(dataset, *inputs), marker="sketch.json") as folder:
        rivals, unseen = _rivals(dataset, networks, models, everyone)
        tables, counts, gallery = _evaluate(rivals, unseen.data, trained, count, seed)
        recipe = provenance("evaluate sketch", [dataset / MANIFEST, *networks, *models], seed)
        own = tables[UNSEEN].as_json() | ({TENTH.replace(" ", "_"): tables[TENTH].as_json()} if trained else {})
        write_json(folder / "sketch.json", recipe | unseen.figures | counts | own)
        write_png(folder / "errors.png", error_maps(rivals.model.template, tables[UNSEEN].maps))
        write_png(folder / "strokes.png", _strokes(tables[UNSEEN], len(rivals.hand.curves)))
        write_png(folder / "gallery.png", gallery)
    echo_notes(unseen.note)
    _print(tables, counts)
    echo_result(f"{shown(out)}: {next(iter(tables[UNSEEN].errors.values()))['noise']:.2f} mm with noise")


def _rivals(dataset: Path, networks: tuple[Path, ...], models: tuple[Path, ...], everyone: bool) -> tuple[Any, Any]:
    """SketchRivals, and the UnseenData of a dataset."""
    from caricli.data.dataset import read_dataset
    from caricli.data.unseen import training_tested, unseen_data
    from caricli.methods.evaluate.evaluate_sketch import SketchRival, SketchRivals
    from caricli.models.linear_model import LinearModel
    from caricli.store.models import check_topology
    from caricli.store.sketch_networks import load_sketch_basis, load_sketch_networks
    from caricli.structures import SeenPeople

    data = read_dataset(dataset)
    pairs = load_sketch_networks(networks, models)
    seen: dict[str, Any] = {}
    for number, (network, basis) in enumerate(pairs, 1):
        check_topology(basis.template, data.template, "the model of the network")
        name = "the network" if len(pairs) == 1 else f"network {number}"
        seen |= {name: SeenPeople.of_recipe(network.recipe), f"{name}'s model": basis.seen}
    with naming(dataset):
        unseen = unseen_data(training_tested(data) if everyone else data, seen)
    linear = [basis for _, basis in pairs if isinstance(basis, LinearModel)]
    rivals = [SketchRival.of(network, basis) for network, basis in pairs]
    return SketchRivals.of(rivals, linear[0] if linear else load_sketch_basis()), unseen


def _evaluate(rivals: Any, data: Any, trained: Path | None, count: int, seed: int) -> tuple[dict, dict, Any]:
    """SketchFigures by protocol, how many faces of each, of how many people, and the gallery's picture."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.evaluate.evaluate_shape import split_rows
    from caricli.methods.evaluate.evaluate_sketch import TENTH, UNSEEN, DrawnHeads, evaluate_sketch
    from caricli.render.sheets.sketch_gallery import sketch_gallery

    rows = {UNSEEN: (data, split_rows(data, "test", 1, count), split_rows(data, "validation", 0, min(count, OTHERS)))}
    if trained is not None:
        rows[TENTH] = _held_out(rivals, trained, count)
    tables = {}
    faces = {}
    with progress_bar("measuring") as report:
        for protocol, (source, tested, others) in rows.items():
            heads = DrawnHeads.of(source.vertices[tested], rivals, report)
            tables[protocol] = evaluate_sketch(rivals, heads, source.vertices[others].astype(float), seed, report)
            faces["faces" if protocol == UNSEEN else "faces_held_out"] = len(tested)
            if protocol == UNSEEN:
                faces["people"] = len(set(source.identity[tested].tolist()))
                gallery = sketch_gallery(rivals.model.template, *rivals.first.shown(heads.some(SHOWN), seed))
    return tables, faces, gallery


def _held_out(rivals: Any, trained: Path, count: int) -> tuple[Any, Any, Any]:
    """A dataset, numbers of the faces of it that all trainings held out, and of those that these validated with."""
    from caricli.data.dataset import MANIFEST, read_dataset
    from caricli.data.held_out import held_out_by_all

    data = read_dataset(trained)
    networks = [rival.network for rival in rivals.networks.values()]
    with naming(trained):
        parts = held_out_by_all(data, {network.held_out for network in networks}, count)
        if not all(made_of(network.recipe, trained / MANIFEST) for network in networks):
            raise InputError("expected a dataset that all networks were trained with, found another")
    return data, parts["test"], parts["validation"][:OTHERS]


def _print(tables: dict, counts: dict) -> None:
    from caricli.commands.shared.tables import print_table
    from caricli.methods.evaluate.evaluate_sketch import CONDITIONS, TENTH, UNSEEN, rows

    print_table(
        ("mm", *CONDITIONS), rows(tables[UNSEEN].errors), f"{counts['faces']} faces of {counts['people']} people"
    )
    if TENTH in tables:
        title = f"{counts['faces_held_out']} faces of people who were trained with, a random tenth"
        print_table(("mm", *CONDITIONS), rows(tables[TENTH].errors), title)


def _strokes(figures: Any, curves: int) -> Any:
    """The errors over the strokes that are left, as a picture."""
    from caricli.render.sheets.plot_curves import plot_curves

    lines = {}
    for name, own in figures.left.items():
        left = sorted(own)
        lines[name] = ([round(curves * share) for share in left], [own[share] for share in left])
    return plot_curves({"as strokes are left out": lines}, "strokes left", "mm, face 200 mm high, with noise")
