"""caricli evaluate shape: models side by side."""

from contextlib import nullcontext
from dataclasses import asdict

import click

from caricli.commands.shared.options import PATH, data_option, each_bundled, overwrite_option
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


@click.command()
@click.argument("models", nargs=-1, required=True, type=PATH, metavar="MODEL...", callback=each_bundled)
@data_option
@click.option("-o", "--out", type=PATH, metavar="JSON", help="Write the figures here as well.")
@click.option("--count", type=click.IntRange(1), metavar="N", help="At most N meshes of a split.  [default: all]")
@overwrite_option
def command(models, dataset, out, count, overwrite):
    """Print the shape error of models on the splits of a dataset, in mm and percent of the head's height.

    A MODEL is a file, or the kind of one that comes with caricli, such as pca.

    \b
    Example:
      caricli evaluate shape pca.safetensors intrinsic.safetensors --data dataset
      caricli evaluate shape run/model.safetensors kernel --data dataset --count 100
    """
    from rich.console import Console
    from rich.table import Table

    from caricli.data.dataset import SPLITS, read_dataset
    from caricli.methods.evaluate.evaluate_shape import evaluate_shape, spread_rows
    from caricli.store.datasets import dataset_files
    from caricli.store.models import check_topology, load_model

    inputs, results = (*models, *dataset_files(dataset)), {}
    table = Table("model", "kind", "D", *(f"{split} mm (%)" for split in SPLITS), "test latent rms")
    with staged(out, overwrite=overwrite, inputs=inputs) if out else nullcontext([None]) as (temporary,):
        data = read_dataset(dataset)
        rows = {split: spread_rows(data.rows(split), count or len(data.vertices)) for split in SPLITS}
        for path in models:
            model = load_model(path)
            check_topology(model.template, data.template, path)
            errors = {split: evaluate_shape(model, data.vertices[rows[split]]) for split in SPLITS}
            cells = [f"{e.millimetres:.3f} ({e.percent:.3f})" if e else "-" for e in errors.values()]
            rms = f"{errors['test'].prior_rms:.2f}" if errors["test"] else "-"
            table.add_row(path.name, model.kind, str(len(model.prior.mean)), *cells, rms)
            results[str(path)] = {split: asdict(e) for split, e in errors.items() if e}
        if temporary:
            write_json(temporary, provenance("evaluate shape", [*models, dataset / "dataset.json"], models=results))
    Console(width=None if Console().is_terminal else 120).print(table)
