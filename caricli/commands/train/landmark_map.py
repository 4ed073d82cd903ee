"""caricli train landmark-map: a map between the landmarks of normal faces and of caricatures."""

from dataclasses import asdict

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    config_option,
    data_option,
    out_option,
    overwrite_option,
    seed_option,
    set_option,
)
from caricli.errors import naming
from caricli.io.checkpoint import write_checkpoint
from caricli.io.config import read_config
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json


@click.command()
@data_option
@out_option(
    "MAP.safetensors", "Write the map here; MAP.json, its recipe and errors, goes beside it.", suffix=".safetensors"
)
@config_option
@set_option
@seed_option
@overwrite_option
def command(dataset, out, config, overrides, seed, overwrite):
    """Train a map between landmarks of normal faces and of caricatures, for `caricli map-landmarks`.

    It learns what caricatures add to faces, from faces of both domains in random poses, never from pairs of them.
    Where the dataset was generated, people held out and those of the test split measure it: caricatures beside the
    regular faces that they were made of.

    \b
    Example:
      caricli train landmark-map --data dataset --out map.safetensors
      caricli train landmark-map --data dataset --out small.safetensors --set styles=1 --seed 1
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.data.dataset import MANIFEST, read_dataset
    from caricli.methods.train.train_landmark_map import train_landmark_map
    from caricli.models.landmark_map.config import LandmarkMapConfig
    from caricli.store.datasets import dataset_files

    settings = read_config(config, LandmarkMapConfig, overrides)
    report_file = out.with_suffix(".json")
    with staged(out, report_file, overwrite=overwrite, inputs=(dataset, config, *dataset_files(dataset))) as files:
        data = read_dataset(dataset)
        recipe = provenance("train landmark-map", [dataset / MANIFEST], seed, config=asdict(settings))
        with naming(dataset):
            training = train_landmark_map(data, settings, seed, recipe, progress_bar)
        write_checkpoint(files[0], *training.checkpoint)
        write_json(files[1], training.recipe | training.figures)
    echo_result(f"{out}: {_summary(training.figures)}")


def _summary(figures: dict) -> str:
    """One line."""
    from caricli.models.landmark_map.model import DOMAINS

    if "test" not in figures.get("error", {}):
        return "no pairs of faces to measure it with"
    test = figures["error"]["test"]
    errors = [f"to {to} {test[to]['map']['error']:.2f} % ({test[to]['identity']['error']:.2f} %)" for to in DOMAINS]
    return f"error {', '.join(errors)} of the face's diagonal, without a map in brackets"
