"""caricli train semantic: directions of labels in the latent space of a model."""

from dataclasses import replace

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import (
    WholeRange,
    data_option,
    model_option,
    out_option,
    overwrite_option,
    seed_option,
)
from caricli.errors import naming
from caricli.io.directions import write_directions
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


@click.command()
@data_option
@out_option("DIRECTIONS.npz", "Write the directions here; DIRECTIONS.json goes beside them.", suffix=".npz")
@model_option
@click.option(
    "--label", "wanted", multiple=True, metavar="NAME", help="Train this label; repeat for more.  [default: all]"
)
@click.option("--count", type=WholeRange(min=1), metavar="N", help="Use N training meshes.  [default: all]")
@seed_option
@overwrite_option
def command(dataset, out, model, wanted, count, seed, overwrite):
    """Find the directions of a dataset's labels in the latents of a model, for `caricli edit-semantic`.

    Every label gets a linear support vector machine. Labels of your own come into a dataset with `caricli dataset
    import --labels`. Of what is printed, AUC is the cross-validated area under the ROC curve, and change is what one
    standard deviation along the direction does to the measure of the label, in standard deviations of that measure.

    \b
    Example:
      caricli train semantic --data dataset --out directions.npz --model pca
      caricli train semantic --data dataset --out noses.npz --label BigNose --label HookNose --count 500
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.commands.shared.tables import print_directions
    from caricli.data.dataset import MANIFEST, read_dataset
    from caricli.data.unseen import seen_people
    from caricli.methods.train.train_semantic import LabelChoice, train_semantic
    from caricli.store.datasets import dataset_files
    from caricli.store.models import DEFAULT_LATENT, check_topology, load_model

    report_file = out.with_suffix(".json")
    with staged(out, report_file, overwrite=overwrite, inputs=(model, *dataset_files(dataset))) as files:
        shape_model = load_model(model, DEFAULT_LATENT)
        data = read_dataset(dataset)
        check_topology(shape_model.template, data.template, model or DEFAULT_LATENT)
        with naming(dataset):
            learnt, skipped = train_semantic(shape_model, data, LabelChoice(wanted, count or 0, seed), progress_bar)
        recipe = provenance("train semantic", [dataset / MANIFEST], seed, meshes=learnt.count)
        recipe |= seen_people(data).as_recipe()
        write_directions(files[0], replace(learnt, recipe=recipe))
        figures = {"model_id": learnt.model_id, "labels": learnt.figures, "skipped": skipped}
        write_json(files[1], recipe | figures)
    print_directions(learnt)
    for name, reason in skipped.items():
        echo_notes(f"{name}: left out, {reason}")
    echo_result(f"{out}: {len(learnt.names)} labels from {learnt.count} meshes")
