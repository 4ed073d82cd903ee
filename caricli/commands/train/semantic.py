"""caricli train semantic: directions of labels in the latent space of a model."""

from dataclasses import replace

import click
import numpy as np

from caricli.commands.shared.options import data_option, model_option, out_option, overwrite_option, seed_option
from caricli.errors import InputError
from caricli.io.directions import write_directions
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

BATCH, MEASURED = 16, 24


@click.command()
@data_option
@out_option("DIRECTIONS.npz", "The directions; DIRECTIONS.json is written beside them.", suffix=".npz")
@model_option
@click.option("--label", "wanted", multiple=True, metavar="NAME", help="A label to train; repeat for more.  [all]")
@click.option("--count", type=click.IntRange(min=1), metavar="N", help="Use this many training meshes.  [all]")
@seed_option
@overwrite_option
def command(dataset, out, model, wanted, count, seed, overwrite):
    """Find the directions of a dataset's labels in the latents of a model, for `caricli edit-semantic`.

    One linear support vector machine per label. Labels of your own come into a dataset with `caricli dataset import
    --labels`. AUC: cross-validated area under the ROC curve. Change: what one standard deviation along the direction
    does to the measure of the label, in standard deviations of that measure.

    \b
    Example:
      caricli train semantic --data dataset --out directions.npz --model pca
      caricli train semantic --data dataset --out noses.npz --label BigNose --label HookNose --count 500
    """
    from caricli.data.dataset import read_dataset
    from caricli.store.datasets import dataset_files
    from caricli.store.models import DEFAULT_LATENT, check_topology, load_model

    report_file = out.with_suffix(".json")
    with staged(out, report_file, overwrite=overwrite, inputs=(model, *dataset_files(dataset))) as files:
        shape_model, data = load_model(model, DEFAULT_LATENT), read_dataset(dataset)
        check_topology(shape_model.template, data.template, model or DEFAULT_LATENT)
        labels = _columns(data.attributes, wanted, dataset)
        directions, skipped = _learn(shape_model, data, labels, count, seed, dataset)
        for name in wanted:
            if name in skipped:
                raise InputError(f"label {name}: {skipped[name]}")
        recipe = provenance("train semantic", [dataset / "dataset.json"], seed, meshes=directions.count)
        people = _people(shape_model, data)
        directions = replace(directions, model_id=shape_model.model_id, recipe=recipe, people=people)
        write_directions(files[0], directions)
        figures = {"labels": figures_of(directions), "skipped": skipped}
        write_json(files[1], recipe | {"model_id": shape_model.model_id} | figures)
    print_table(directions)
    for name, reason in skipped.items():
        click.echo(f"{name}: left out, {reason}", err=True)
    click.echo(f"{out}: {len(directions.names)} labels from {directions.count} meshes")


def figures_of(directions):
    """What the JSON says of Directions: a dict of names to figures."""
    keys = ("auc", "positives", "cost", "change")
    columns = {key: np.asarray(getattr(directions, key)).tolist() for key in keys}
    return {name: {key: columns[key][k] for key in keys} for k, name in enumerate(directions.names)}


def print_table(directions):
    """Print names, AUC, counts and changes of Directions."""
    width = max(map(len, ("label", *directions.names)))
    click.echo(f"{'label':{width}}    AUC  positives  change")
    for name, row in figures_of(directions).items():
        click.echo(f"{name:{width}}  {row['auc']:5.3f}  {row['positives']:9}  {row['change']:6.2f}")


def _columns(attributes, wanted, dataset):
    """Where the wanted labels stand in a dataset, or all of them."""
    if not len(attributes):
        raise InputError(f"{dataset}: expected labels, found none; they come in with caricli dataset import --labels")
    unknown = [name for name in wanted if name not in attributes]
    if unknown:
        raise InputError(f"{dataset}: expected one of the labels {', '.join(attributes)}, found {unknown[0]!r}")
    return [attributes.index(name) for name in dict.fromkeys(wanted)] or list(range(len(attributes)))


def _learn(model, data, columns, count, seed, where):
    """Directions of some labels of a Dataset, and what was left out."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.methods.evaluate.evaluate_shape import spread_rows
    from caricli.methods.train.train_semantic import measure_directions, train_semantic

    rows = spread_rows(data.rows("train"), count or len(data.vertices))
    if not len(rows):
        raise InputError(f"{where}: expected training meshes, found none")
    with progress_bar("encoding") as report:
        latents = _encode(model, data.vertices[rows], report)
    names, measures = [data.attributes[k] for k in columns], data.measures[rows][:, columns].astype(float)
    with progress_bar("labels") as report:
        labels = data.labels[rows][:, columns]
        directions, skipped = train_semantic(latents, labels, names, data.identity[rows], measures, seed, report)
    some = latents[np.linspace(0, len(rows) - 1, min(MEASURED, len(rows))).astype(int)]
    spreads = dict(zip(names, measures.std(0), strict=True))
    return measure_directions(directions, some, model, spreads), skipped


def _people(model, data):
    """(I, D) whitened latents of the most regular test mesh of every person."""
    from caricli.commands.shared.progress import progress_bar

    test = np.flatnonzero(data.rows("test"))
    test = test[np.argsort(data.level[test], kind="stable")]
    _, first = np.unique(data.identity[test], return_index=True)
    if not len(first):
        return np.zeros((0, len(model.prior.mean)))
    with progress_bar("people") as report:
        return _encode(model, data.vertices[test[first]], report)


def _encode(model, shapes, report):
    """(N, D) whitened latents of shapes (N, V, 3)."""
    latents = []
    for start in range(0, len(shapes), BATCH):
        latents.append(model.prior.whiten(model.encode(shapes[start : start + BATCH].astype(float))))
        report(start + len(latents[-1]), len(shapes))
    return np.concatenate(latents)
