"""caricli train style: pictures in the look of others."""

from dataclasses import asdict

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import PATH, config_option, out_option, overwrite_option, set_option
from caricli.io.config import read_config
from caricli.io.provenance import provenance


@click.command()
@click.option(
    "--drawings",
    type=PATH,
    metavar="DIR",
    help="Learn from the pictures in this folder, too. One that cannot be read is left out, with a note.",
)
@out_option("RUN_DIR", "Write model, log, learning curve and the state to resume from into this folder.")
@config_option
@set_option
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@overwrite_option
def command(drawings, out, config, overrides, resume, overwrite):
    """Train the network that gives a texture the style of a drawing (expressions paper, section 3.3.2).

    Between a small encoder and a decoder means and deviations of the features become those of the style (adaptive
    instance normalisation). It learns from generated faces in oil, watercolour, ink, pencil, hatching, flat colours and
    print. The model of the best validation is in RUN_DIR/model.safetensors, with recipe and errors in model.json.
    Killed at any moment, the same command with --resume ends in the same model. Under torchrun every process takes its
    share of each batch.

    \b
    Example:
      caricli train style --out run
      caricli train style --drawings drawings --out run --resume
    """
    from caricli.commands.shared.progress import progress_bar, training_bar
    from caricli.methods.train.processes import training_processes
    from caricli.models.style.config import StyleConfig
    from caricli.store.style_run import StyleRun, style_training
    from caricli.store.styles import load_style_drawings
    from caricli.store.training_run import MODEL, Beginning

    settings = read_config(config, StyleConfig, overrides)
    with training_processes("cpu") as share:
        pictures, notes = ({}, []) if drawings is None else load_style_drawings(drawings)
        recipe = provenance("train style", pictures, config=asdict(settings))
        run = StyleRun(out, recipe, Beginning(resume, overwrite, share.process == 0, (drawings, config)))
        echo_notes(*(f"caricli: {note}" for note in notes if run.writes))
        with progress_bar("painting") as report:
            training = style_training(list(pictures.values()), settings, share, report)
        with training_bar(settings.epochs, quiet=not run.writes) as show:
            for line in run.follow(training):
                show(line)
        if run.writes:
            figures = run.finish(training)
            echo_result(f"{out / MODEL}: {figures['error']:.2f} % off, left as they are {figures['kept']:.2f} %")
