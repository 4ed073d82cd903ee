"""caricli train gesture: what a stroke of the pen means."""

from dataclasses import asdict

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import config_option, out_option, overwrite_option, set_option
from caricli.io.config import read_config
from caricli.io.provenance import provenance


@click.command()
@out_option("RUN_DIR", "Write model, log, learning curve and the state to resume from into this folder.")
@config_option
@set_option
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@overwrite_option
def command(out, config, overrides, resume, overwrite):
    """Train the network that tells ten pen gestures apart (sketch paper, section 5.2).

    It learns from strokes of generated hands, each drawn once: line, region, left and right arrow, and rolls with one,
    two or three loops above or below a line. The model of the best validation is in RUN_DIR/model.safetensors, with
    recipe and errors in model.json. Killed at any moment, the same command with --resume ends in the same model. Under
    torchrun every process takes its share of each batch.

    \b
    Example:
      caricli train gesture --out run
      caricli train gesture --out run --resume
    """
    from caricli.commands.shared.progress import training_bar
    from caricli.methods.train.processes import training_processes
    from caricli.methods.train.train_gesture import GestureTraining
    from caricli.models.gesture.config import GestureConfig
    from caricli.store.gesture_run import GestureRun
    from caricli.store.training_run import MODEL, Beginning

    settings = read_config(config, GestureConfig, overrides)
    with training_processes("cpu") as share:
        recipe = provenance("train gesture", [], config=asdict(settings))
        run = GestureRun(out, recipe, Beginning(resume, overwrite, share.process == 0, (config,)))
        training = GestureTraining(settings, share)
        with training_bar(settings.epochs, quiet=not run.writes) as show:
            for line in run.follow(training):
                show(line)
        if run.writes:
            figures = run.finish(training)
            echo_result(f"{out / MODEL}: {figures['right']:.2f} % of further strokes told right")
