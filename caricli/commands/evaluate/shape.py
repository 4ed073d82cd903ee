"""caricli evaluate shape: models side by side."""

from contextlib import nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import PATH, WholeRange, data_option, each_bundled, overwrite_option
from caricli.errors import naming, shown
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


@click.command()
@click.argument("models", nargs=-1, required=True, type=PATH, metavar="MODEL...", callback=each_bundled)
@data_option
@click.option("-o", "--out", type=PATH, metavar="JSON", help="Write the figures into this file, too.")
@click.option(
    "--count", type=WholeRange(1), metavar="N", help="Measure at most N meshes of every split.  [default: all]"
)
@click.option(
    "--everyone", is_flag=True, help="Test with all people that the models were not trained with, not with a split."
)
@overwrite_option
def command(models, dataset, out, count, everyone, overwrite):
    """Print the shape error of models on the splits of a dataset, in mm and percent of the head's height.

    A MODEL is a file, or the kind of one that comes with caricli, such as pca. Whom one of them was trained with is
    left out of the test split for all, which takes a dataset of another --seed, or the models' own.

    \b
    Example:
      caricli evaluate shape pca.safetensors intrinsic.safetensors --data dataset
      caricli evaluate shape run/model.safetensors kernel --data dataset --everyone --count 100
    """
    from caricli.commands.shared.tables import print_table
    from caricli.data.dataset import MANIFEST, SPLITS, read_dataset
    from caricli.data.unseen import unseen_data
    from caricli.methods.evaluate.evaluate_shape import evaluate_splits
    from caricli.store.datasets import dataset_files

    inputs = (*models, *dataset_files(dataset))
    rows = []
    results = {}
    with staged(out, overwrite=overwrite, inputs=inputs) if out else nullcontext([None]) as (temporary,):
        data = read_dataset(dataset)
        loaded = {path: _of_mesh(path, data) for path in models}
        with naming(dataset):
            unseen = unseen_data(data, {_name(path, models): model.seen for path, model in loaded.items()}, everyone)
        for path, model in loaded.items():
            errors = evaluate_splits(model, unseen.data, count=count or 0)
            results[str(path)] = {split: asdict(error) for split, error in errors.items()}
            rows.append((*_about(path, model), *(_cell(errors.get(split)) for split in SPLITS), _spread(errors)))
        if temporary:
            recipe = provenance("evaluate shape", [*models, dataset / MANIFEST])
            write_json(temporary, recipe | unseen.figures | {"models": results})
    echo_notes(unseen.note)
    print_table(("model", "kind", "D", *(f"{split} mm (%)" for split in SPLITS), "test latent rms"), rows)
    if out:
        echo_result(f"{shown(out)}: {len(rows)} models")


def _of_mesh(path: Path, data: Any) -> Any:
    """The ShapeModel of a file, which must be of a Dataset's mesh."""
    from caricli.store.models import check_topology, load_model

    model = load_model(path)
    check_topology(model.template, data.template, path)
    return model


def _name(path: Path, models: tuple[Path, ...]) -> str:
    """What a message calls one of the models: the name of its file, where no other has the same."""
    return path.name if [other.name for other in models].count(path.name) == 1 else str(path)


def _about(path: Path, model: Any) -> tuple[str, str, str]:
    """Name, kind and dimension of a ShapeModel."""
    return path.name, model.kind, str(len(model.prior.mean))


def _cell(error: Any) -> str:
    """A ShapeError, or "-" for none."""
    return "-" if error is None else f"{error.millimetres:.3f} ({error.percent:.3f})"


def _spread(errors: dict) -> str:
    """Root mean square latent of the test meshes among ShapeErrors by split."""
    return f"{errors['test'].prior_rms:.2f}" if "test" in errors else "-"
