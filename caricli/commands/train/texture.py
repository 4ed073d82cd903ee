"""caricli train texture: textures that follow the expression."""

from dataclasses import asdict

import click

from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import PATH, config_option, out_option, overwrite_option, set_option
from caricli.io.config import read_config
from caricli.io.provenance import provenance


@click.command()
@click.option(
    "--data",
    "folders",
    type=PATH,
    metavar="DIR",
    multiple=True,
    required=True,
    help="Train on this folder of `caricli dataset textures`; repeatable.",
)
@out_option("RUN_DIR", "Write model, log, learning curve and the state to resume from into this folder.")
@click.option(
    "--styles",
    type=PATH,
    metavar="DIR",
    help="Paint people in the styles of the drawings in this folder.  [default: generated styles]",
)
@click.option(
    "--drawings",
    type=PATH,
    metavar="DIR",
    help="Train the unpaired part on this folder of `caricli dataset textures`.  [default: those of --data]",
)
@config_option
@set_option
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@overwrite_option
def command(folders, out, styles, drawings, config, overrides, resume, overwrite):
    """Train the network that paints a face's texture as another expression shows it.

    First on pairs of expressions of the same people, then without pairs. The model of the best validation is in
    RUN_DIR/model.safetensors, with recipe and errors in model.json. Killed at any moment, the same command with
    --resume ends in the same model. Under torchrun every process takes its share of each batch. People of the
    validation and test splits are not trained with.

    \b
    Example:
      caricli train texture --data textures --out run
      caricli train texture --data textures --styles drawings --out run --resume
    """
    from caricli.commands.shared.progress import progress_bar, training_bar
    from caricli.data.texture_set import read_texture_set
    from caricli.data.unseen import training_entry
    from caricli.methods.train.processes import training_processes
    from caricli.models.texture.config import TextureConfig
    from caricli.store.styles import load_style_book
    from caricli.store.texture_run import TextureRun, load_texture_ingredients, texture_sources
    from caricli.store.training_run import MODEL, Beginning

    settings = read_config(config, TextureConfig, overrides)
    with training_processes("cpu") as share:
        book, notes = load_style_book(styles, settings.seed)
        recipe = provenance("train texture", texture_sources(folders, drawings, styles), config=asdict(settings))
        recipe |= training_entry([read_texture_set(folder) for folder in (*folders, drawings) if folder is not None])
        beginning = Beginning(resume, overwrite, share.process == 0, (*folders, drawings, styles, config))
        run = TextureRun(out, recipe, beginning)
        echo_notes(*(f"caricli: {note}" for note in notes if run.writes))
        with progress_bar("painting") as report:
            training = load_texture_ingredients(folders, drawings, settings, book, report).training(settings, share)
        with training_bar(settings.epochs, quiet=not run.writes) as show:
            for line in run.follow(training):
                show(line)
        if run.writes:
            figures = run.finish(training)
            echo_result(f"{out / MODEL}: {figures['percent_of_kept']:.0f} % of the difference of the texture kept")
