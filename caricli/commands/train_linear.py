"""What the `caricli train` commands share whose models come from decompositions."""

from dataclasses import asdict

import click

from caricli.commands.shared.options import config_option, data_option, out_option, overwrite_option, set_option
from caricli.errors import InputError
from caricli.io.checkpoint import write_checkpoint
from caricli.io.config import read_config
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


def training_command(function):
    """Give a function the options of a training command."""
    for option in (
        overwrite_option,
        set_option,
        config_option,
        out_option("MODEL", "The .safetensors to write."),
        data_option,
    ):
        function = option(function)
    return click.command()(function)


def train_linear(kind, dataset, out, config, overrides, overwrite):
    """Train a model of components, measure it, and write it with a JSON of recipe and errors beside it."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.albedo import random_albedos
    from caricli.data.dataset import SPLITS, read_dataset
    from caricli.methods.evaluate.evaluate_shape import evaluate_shape
    from caricli.models.checkpoint import model_class, model_from_checkpoint, model_to_checkpoint
    from caricli.models.config import KernelConfig, LinearConfig, MorphableConfig
    from caricli.store.datasets import dataset_files

    if out.suffix != ".safetensors":
        raise InputError(f"{out}: expected a name that ends in .safetensors")
    configs = {"kernel": KernelConfig, "morphable": MorphableConfig}
    settings = read_config(config, configs.get(kind, LinearConfig), overrides)
    report = out.with_suffix(".json")
    inputs = (dataset, config, *dataset_files(dataset))
    with (
        staged(out, report, overwrite=overwrite, inputs=inputs) as (model_file, report_file),
        progress_bar(f"training {kind}") as progress,
    ):
        progress(0, 3)
        data = read_dataset(dataset)
        rows = data.rows("train")
        training = data.vertices[rows]
        if len(training) < 3:
            raise InputError(f"{dataset}: its training split has {len(training)} meshes, at least 3 are needed")
        progress(1, 3)
        recipe = provenance(f"train {kind}", [dataset / "dataset.json"], settings.seed, config=asdict(settings))
        more = ()
        if kind == "morphable":
            more = (data.identity[rows], data.expression[rows], random_albedos(data.template, settings.seed))
        trained = model_class(kind).train(data.template, training, *more, **asdict(settings))
        progress(2, 3)
        checkpoint = model_to_checkpoint(trained, recipe)
        write_checkpoint(model_file, *checkpoint)
        model = model_from_checkpoint(*checkpoint, str(out))
        errors = {split: evaluate_shape(model, data.vertices[data.rows(split)]) for split in SPLITS}
        errors = {split: asdict(error) for split, error in errors.items() if error is not None}
        figures = {"model_id": model.model_id, "shape_error": errors}
        if kind == "morphable":
            figures["agreement"] = _agreement(model, data)
        write_json(report_file, recipe | figures)
        progress(3, 3)
    shown = ", ".join(f"{split} {error['percent']:.3f} %" for split, error in errors.items())
    click.echo(f"{out}: {len(model.prior.mean)} dimensions, shape error {shown} of the head's height")


def _agreement(model, data):
    """How well a morphable model tells who from what on test meshes, and on those that are not exaggerated."""
    from caricli.methods.evaluate.measure_separation import measure_separation

    groups = {"test": data.rows("test")}
    if "kind" in data.factors:
        groups["test_regular"] = groups["test"] & (data.factors["kind"] == 0)
    return {
        name: measure_separation(model, data.vertices[rows], data.identity[rows], data.expression[rows])
        for name, rows in groups.items()
    }
