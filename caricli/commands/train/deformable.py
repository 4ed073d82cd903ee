"""caricli train deformable: the SIREN hypernetwork."""

from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    config_option,
    data_option,
    device_option,
    out_option,
    overwrite_option,
    set_option,
)
from caricli.errors import naming
from caricli.io.config import read_config
from caricli.io.provenance import provenance

if TYPE_CHECKING:
    from caricli.data.dataset import Dataset
    from caricli.store.training_run import TrainingRun


@click.command()
@data_option
@out_option("RUN_DIR", "Write model, log, loss curve and the state to resume from into this folder.")
@config_option
@set_option
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@device_option
@click.option(
    "--template",
    type=PATH,
    metavar="OBJ",
    help="Deform this mesh, no two parts of which touch.  [default: the head with its lips apart]",
)
@overwrite_option
def command(dataset, out, config, overrides, resume, device, template, overwrite):
    """Train a SIREN that deforms the template, its weights made from a latent by a hypernetwork.

    The model of the best validation is in RUN_DIR/model.safetensors, with recipe and errors in model.json. Killed at
    any moment, the same command with --resume ends in the same model. Under torchrun every process takes its share of
    each batch.

    \b
    Example:
      caricli train deformable --data dataset --out run
      caricli train deformable --data dataset --out run --resume
      caricli train deformable --data dataset --out paper --config configs/deformable/paper.yaml --device cuda
    """
    from caricli.commands.shared.progress import training_bar
    from caricli.commands.shared.training import chosen_device, network_points
    from caricli.data.dataset import MANIFEST, read_dataset
    from caricli.data.unseen import seen_people
    from caricli.methods.train.deformable.train_deformable import train_deformable
    from caricli.methods.train.processes import training_processes
    from caricli.models.deformable.config import DeformableConfig
    from caricli.store.training_run import MODEL, Beginning, TrainingRun

    settings = read_config(config, DeformableConfig, overrides)
    place = chosen_device(device)
    with training_processes(place) as share:
        data = read_dataset(dataset)
        recipe = provenance("train deformable", [dataset / MANIFEST, template], config=asdict(settings))
        recipe |= seen_people(data).as_recipe()
        run = TrainingRun(out, recipe, Beginning(resume, overwrite, share.process == 0, (dataset, template, config)))
        points = network_points(data.template, template)
        with naming(dataset):
            training = train_deformable(data, points, settings, place, share)
        with training_bar(settings.epochs, quiet=not run.writes) as show:
            for line in run.follow(training, data.template):
                show(line)
        if run.writes:
            echo_result(f"{out / MODEL}: {_measured(run, data)}")


def _measured(run: "TrainingRun", data: "Dataset") -> str:
    """The errors of the model that a training ends in, as they are printed."""
    from caricli.commands.shared.progress import progress_bar
    from caricli.commands.shared.tables import shape_errors

    with progress_bar("measuring") as progress:
        return shape_errors(run.finish(data, progress))
