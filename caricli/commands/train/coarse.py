"""caricli train coarse: pictures to the coefficients of the morphable model."""

from dataclasses import asdict

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    config_option,
    datasets_option,
    model_option,
    out_option,
    overwrite_option,
    set_option,
)
from caricli.io.config import read_config
from caricli.io.provenance import provenance


@click.command()
@datasets_option(
    "Use the dataset in this folder; and, repeated, one for each folder of `caricli dataset pictures`, in their order."
)
@click.option(
    "--pictures",
    type=PATH,
    metavar="DIR",
    required=True,
    multiple=True,
    help="Train on this folder of `caricli dataset pictures`, made of the dataset; and, repeated, on further ones, and "
    "on folders of any pictures with faces.",
)
@out_option("RUN_DIR", "Write model, log, learning curve and the state to resume from into this folder.")
@model_option
@click.option("--detector", type=PATH, metavar="FILE", help="See landmarks with this detector.  [default: caricli's]")
@config_option
@set_option
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@overwrite_option
def command(datasets, pictures, out, model, detector, config, overrides, resume, overwrite):
    """Train the network from a picture to identity, expression, colours, light and pose, for `caricli fit-coarse`.

    It learns to draw the pictures again (portrait paper, equations 3 to 6), and from rendered pictures what is true of
    them, too. The model of the best validation is in RUN_DIR/model.safetensors, with recipe and errors in model.json.
    Killed at any moment, the same command with --resume ends in the same model. Under torchrun every process takes its
    share of each batch. People of the dataset's validation and test splits are not trained with.

    \b
    Example:
      caricli train coarse --data people --pictures pictures --out run
      caricli train coarse --data people --pictures pictures --pictures drawings --out run --resume
      caricli train coarse --data people --pictures pictures --data others --pictures their-pictures --out run
    """
    from caricli.commands.shared.progress import progress_bar, training_bar
    from caricli.data.dataset import MANIFEST
    from caricli.methods.train.coarse.train_coarse import CoarseTraining
    from caricli.methods.train.processes import training_processes
    from caricli.models.coarse.config import CoarseConfig
    from caricli.store.coarse_run import CoarseRun, load_ingredients
    from caricli.store.training_run import MODEL, Beginning

    settings = read_config(config, CoarseConfig, overrides)
    with training_processes("cpu") as share:
        with progress_bar("looking for faces") as progress:
            given = load_ingredients(datasets, pictures, model, detector, progress)
        sources = [*(folder / MANIFEST for folder in datasets), model, detector]
        recipe = provenance("train coarse", sources, config=asdict(settings))
        recipe |= given.recipe | {"inputs": recipe["inputs"] | given.inputs}
        beginning = Beginning(resume, overwrite, share.process == 0, (*datasets, *pictures, model, detector, config))
        run = CoarseRun(out, recipe, beginning)
        training = CoarseTraining(given.sources, given.model, given.detector, settings, share)
        with training_bar(settings.epochs, quiet=not run.writes) as show:
            for line in run.follow(training):
                show(line)
        if run.writes:
            echo_result(f"{out / MODEL}: shape error {run.finish(training)['validation']:.2f} % of the head's height")
