"""caricli train detector: faces, landmarks and regions of pictures."""

from dataclasses import asdict

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    PATH,
    config_option,
    device_option,
    out_option,
    overwrite_option,
    set_option,
)
from caricli.io.config import read_config
from caricli.io.provenance import provenance


@click.command()
@click.option(
    "--pictures",
    type=PATH,
    metavar="DIR",
    multiple=True,
    required=True,
    help="Train on this folder of `caricli dataset pictures`; repeatable.",
)
@out_option("RUN_DIR", "Write model, log, learning curve and the state to resume from into this folder.")
@config_option
@set_option
@click.option(
    "--start", type=PATH, metavar="FILE", help="Begin with the weights of this detector, to train it further."
)
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@device_option
@overwrite_option
def command(pictures, out, config, overrides, start, resume, device, overwrite):
    """Train the network that finds faces, their landmarks and regions, for `caricli detect`.

    The model of the best validation is in RUN_DIR/model.safetensors, with recipe and errors in model.json. Killed at
    any moment, the same command with --resume ends in the same model. Under torchrun every process takes its share of
    each batch, which on two cores is faster than two threads; what a GPU learns from is drawn by all cores but two.
    People of the dataset's validation and test splits are not trained with.

    \b
    Example:
      caricli train detector --pictures pictures --out run
      caricli train detector --pictures pictures --out run --resume
      caricli train detector --pictures pictures --pictures more --start run/model.safetensors --out further
      caricli train detector --pictures pictures --out run --config configs/detector/gpu.yaml --device cuda
    """
    from caricli.commands.shared.progress import progress_bar, training_bar
    from caricli.commands.shared.tables import detector_figures
    from caricli.commands.shared.training import chosen_device
    from caricli.data.picture_set import read_picture_set
    from caricli.data.unseen import training_entry
    from caricli.methods.train.processes import training_processes
    from caricli.models.detector.config import DetectorConfig
    from caricli.store.detector_run import DetectorRun, drawing_ahead, load_training
    from caricli.store.training_run import MODEL, Beginning

    settings = read_config(config, DetectorConfig, overrides)
    place = chosen_device(device)
    with training_processes(place) as share:
        sources = [*(folder / "pictures.json" for folder in pictures), *([] if start is None else [start])]
        recipe = provenance("train detector", sources, config=asdict(settings))
        recipe |= training_entry([read_picture_set(folder) for folder in pictures])
        run = DetectorRun(out, recipe, Beginning(resume, overwrite, share.process == 0, (*pictures, start, config)))
        training = load_training(pictures, settings, share, place, start)
        with drawing_ahead(training, pictures), training_bar(settings.epochs, quiet=not run.writes) as show:
            for line in run.follow(training):
                show(line)
        if run.writes:
            with progress_bar("measuring") as progress:
                figures = run.finish(training, progress)
            echo_result(f"{out / MODEL}: {detector_figures(figures)}")
