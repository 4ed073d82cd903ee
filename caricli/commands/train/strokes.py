"""caricli train strokes: what the strokes of a sketch draw."""

from dataclasses import asdict

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import config_option, datasets_option, out_option, overwrite_option, set_option
from caricli.io.config import read_config
from caricli.io.provenance import provenance


@click.command()
@datasets_option("Draw the faces of the dataset in this folder, and, repeated, of further ones.")
@out_option("RUN_DIR", "Write model, log, learning curve and the state to resume from into this folder.")
@config_option
@set_option
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@overwrite_option
def command(datasets, out, config, overrides, resume, overwrite):
    """Train the network that tells which curve of a face strokes draw, for `caricli reconstruct-from-sketch`.

    Sketches are drawn as they are needed: people of the datasets as hands draw and artists change them, and what people
    draw beside faces. The model of the best validation is in RUN_DIR/model.safetensors, with recipe and errors in
    model.json. Killed at any moment, the same command with --resume ends in the same model. Under torchrun every
    process takes its share of each batch. People of the validation and test splits are not trained with.

    \b
    Example:
      caricli train strokes --data people --out run
      caricli train strokes --data people --data own --out run --resume
    """
    from caricli.commands.shared.progress import progress_bar, training_bar
    from caricli.data.dataset import MANIFEST
    from caricli.data.unseen import everybody
    from caricli.methods.train.processes import training_processes
    from caricli.methods.train.strokes.train_strokes import StrokesTraining
    from caricli.models.strokes.config import StrokesConfig
    from caricli.store.strokes_run import StrokesRun, load_people
    from caricli.store.training_run import MODEL, Beginning

    settings = read_config(config, StrokesConfig, overrides)
    with training_processes("cpu") as share:
        people = load_people(datasets)
        recipe = provenance("train strokes", [folder / MANIFEST for folder in datasets], config=asdict(settings))
        recipe |= everybody(people).as_recipe()
        run = StrokesRun(out, recipe, Beginning(resume, overwrite, share.process == 0, (*datasets, config)))
        with progress_bar("wrinkles") as report:
            training = StrokesTraining(people, settings, share, report)
        with training_bar(settings.epochs, quiet=not run.writes) as show:
            for line in run.follow(training):
                show(line)
        if run.writes:
            figures = run.finish(training)
            echo_result(f"{out / MODEL}: {figures['misread']:.2f} % of the places along further strokes misread")
