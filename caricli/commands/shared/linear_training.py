"""What the `caricli train` commands share whose models come from decompositions."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import config_option, data_option, out_option, overwrite_option, set_option
from caricli.errors import naming
from caricli.io.config import read_config
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


def linear_command(function: Callable) -> click.Command:
    """Make a command of a function, with the options of such a training."""
    for option in (
        overwrite_option,
        set_option,
        config_option,
        out_option(
            "MODEL",
            "Write the model here, as .safetensors; a JSON of the same name goes beside it.",
            suffix=".safetensors",
        ),
        data_option,
    ):
        function = option(function)
    return click.command()(function)


def train_and_write(
    kind: str, dataset: Path, out: Path, config: Path | None, overrides: tuple[str, ...], overwrite: bool
) -> None:
    """Train a model of components, and write it with a JSON of recipe and errors beside it."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.commands.shared.tables import shape_errors
    from caricli.data.dataset import MANIFEST, read_dataset
    from caricli.data.unseen import seen_people
    from caricli.io.checkpoint import write_checkpoint
    from caricli.methods.train.train_linear import train_linear
    from caricli.models.kinds import config_class
    from caricli.store.datasets import dataset_files

    settings = read_config(config, config_class(kind), overrides)
    inputs = (dataset, config, *dataset_files(dataset))
    with (
        staged(out, out.with_suffix(".json"), overwrite=overwrite, inputs=inputs) as (model_file, report_file),
        progress_bar(f"training {kind}") as report,
    ):
        data = read_dataset(dataset)
        recipe = provenance(f"train {kind}", [dataset / MANIFEST], settings.seed, config=asdict(settings))
        recipe |= seen_people(data).as_recipe()
        with naming(dataset):
            training = train_linear(kind, data, settings, recipe, report)
        write_checkpoint(model_file, *training.checkpoint)
        write_json(report_file, recipe | training.figures)
    dimensions = len(training.model.prior.mean)
    echo_result(f"{out}: {dimensions} dimensions, {shape_errors(training.errors)}")
