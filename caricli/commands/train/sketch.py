"""caricli train sketch: sketches to faces."""

from dataclasses import asdict

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
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
@datasets_option("Draw the faces of the dataset in this folder, and, repeated, of further ones.")
@out_option("RUN_DIR", "Write model, log, learning curve and the state to resume from into this folder.")
@model_option
@config_option
@set_option
@click.option("--resume", is_flag=True, help="Go on from the last checkpoint in RUN_DIR; begin where there is none.")
@overwrite_option
def command(datasets, out, model, config, overrides, resume, overwrite):
    """Train the network from a sketch to a face, for `caricli reconstruct-from-sketch`.

    Sketches are drawn as they are needed, as hands draw, of people of the datasets and of mixtures of them. The model
    of the best validation is in RUN_DIR/model.safetensors, with recipe and errors in model.json; it tells latents of
    --model, by default the bundled pca. Killed at any moment, the same command with --resume ends in the same model.
    Under torchrun every process takes its share of each batch. People of the validation and test splits are not trained
    with.

    --set variant=pixel_shape, pixel, pixel_plain, shape or pixel_single trains a network of DeepSketch2Face as
    published instead: on a full grid, towards the u and v of a --model of `caricli train bilinear`. configs/sketch has
    published.yaml for two cores, and paper.yaml.

    \b
    Example:
      caricli train sketch --data grid --out run
      caricli train sketch --data grid --data people --out run --resume
      caricli train sketch --data grid --model bilinear.safetensors --config published.yaml --out pixel_shape
    """
    from caricli.commands.shared.progress import progress_bar, training_bar
    from caricli.data.dataset import MANIFEST
    from caricli.data.unseen import everybody
    from caricli.methods.train.processes import training_processes
    from caricli.models.sketch.config import SketchConfig
    from caricli.store.sketch_run import SketchRun, load_sketch_ingredients, sketch_training
    from caricli.store.training_run import MODEL, Beginning

    settings = read_config(config, SketchConfig, overrides)
    with training_processes("cpu") as share:
        people, basis = load_sketch_ingredients(datasets, model, settings)
        sources = [*(folder / MANIFEST for folder in datasets), model]
        recipe = provenance("train sketch", sources, config=asdict(settings)) | everybody(people).as_recipe()
        run = SketchRun(out, recipe, Beginning(resume, overwrite, share.process == 0, (*datasets, model, config)))
        with progress_bar("wrinkles") as report:
            training = sketch_training(people, basis, settings, share, report)
        with training_bar(settings.epochs, quiet=not run.writes) as show:
            for line in run.follow(training):
                show(line)
        if run.writes:
            figures = run.finish(training)
            echo_result(f"{out / MODEL}: {figures['millimetres']:.2f} mm from faces of no training")
