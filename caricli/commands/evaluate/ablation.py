"""caricli evaluate ablation: what each choice of the deformable model is worth."""

import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from caricli.commands.shared.notes import echo_result
from caricli.commands.shared.options import (
    config_option,
    data_option,
    device_option,
    out_option,
    overwrite_option,
    set_option,
)
from caricli.errors import UsageError, naming, shown
from caricli.io.config import read_config
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder, write_bytes
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.models.config import MAX_SEED

_SEED = re.compile("[0-9]{1,10}")


def _seeds(ctx, param, value):
    """Numbers between commas, each once; none where it is not given."""
    words = [] if value is None else [word.strip() for word in value.split(",")]
    seeds = {int(word): None for word in words if _SEED.fullmatch(word) and int(word) <= MAX_SEED}
    if len(seeds) < len(words):
        raise UsageError(f"--seeds: expected whole numbers up to {MAX_SEED}, each once, found {shown(value, 60)}")
    return tuple(seeds)


_COLUMNS = ("model", "parameters", "train %", "test %", "test surface %", "training s", "λ_reg")


@click.command()
@data_option
@out_option("DIR", "Write ablation.png, ablation.json and ablation.md into this folder.")
@config_option
@set_option
@click.option(
    "--seeds",
    metavar="S,S,...",
    callback=_seeds,
    help="Train everything with each of these seeds; the table holds means and, after ±, standard deviations.  "
    "[default: the settings' seed]",
)
@device_option
@overwrite_option
def command(dataset, out, config, overrides, seeds, device, overwrite):
    """Train the deformable model beside its rivals on the same meshes and compare their errors.

    The rivals are arrays of vertex positions and displacements, a SIREN that takes the latent as a further input,
    training without points between the vertices, PCA and the intrinsic model. DIR gets ablation.png (errors of four
    networks during the training: on training meshes every epoch, on test meshes whose codes follow it at every
    validation), ablation.md and ablation.json (the table, at the end, when the test codes are fitted to the last).

    \b
    Example:
      caricli evaluate ablation --data dataset --out ablation
      caricli evaluate ablation --data dataset --out ablation --set start=principal
      caricli evaluate ablation --data dataset --out ablation --seeds 0,1,2 --set latent_weight=1e6
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.commands.shared.tables import print_table
    from caricli.commands.shared.training import chosen_device, network_points
    from caricli.data.dataset import MANIFEST, read_dataset
    from caricli.methods.evaluate.evaluate_ablation import NETWORKS, ablation_meshes, evaluate_seeds
    from caricli.models.ablation.config import AblationConfig
    from caricli.store.datasets import dataset_files

    settings = read_config(config, AblationConfig, overrides)
    place = chosen_device(device)
    inputs = (dataset, config, *dataset_files(dataset))
    with (
        staged_folder(out, overwrite=overwrite, inputs=inputs, marker="ablation.json") as folder,
        progress_bar(f"training {len(NETWORKS)} networks") as report,
    ):
        data = read_dataset(dataset)
        recipe = provenance("evaluate ablation", [dataset / MANIFEST], settings.seed, config=asdict(settings))
        points = network_points(data.template)
        with naming(dataset):
            meshes = ablation_meshes(data, points, settings, place)
        rows = evaluate_seeds(data.template, meshes, settings, seeds or (settings.seed,), report)
        _write(folder, rows, recipe | {"meshes": len(meshes.shapes), "unseen": len(meshes.unseen)})
    print_table(_COLUMNS, map(_cells, rows))
    echo_result(f"{shown(out)}: {len(rows)} networks")


def _write(folder: Path, models: list, recipe: dict) -> None:
    """Write AblationFigures as JSON and Markdown, and their curves."""
    from caricli.methods.evaluate.evaluate_ablation import DRAWN
    from caricli.render.sheets.plot_curves import plot_curves

    curves = {model.mean.name: model.mean.curves for model in models if model.mean.curves}
    write_json(folder / "ablation.json", recipe | {"models": [_figures(model) for model in models], "curves": curves})
    lines = [_COLUMNS, ["---"] * len(_COLUMNS), *map(_cells, models)]
    write_bytes(folder / "ablation.md", "".join(f"| {' | '.join(line)} |\n" for line in lines).encode())
    panels = {
        f"{split} error": {name: tuple(zip(*curves[name][split], strict=True)) for name in DRAWN}
        for split in ("train", "test")
    }
    write_png(folder / "ablation.png", plot_curves(panels))


def _figures(model: Any) -> dict[str, Any]:
    """A JSON object of AblationFigures."""
    figures = {key: value for key, value in asdict(model.mean).items() if key != "curves" and value is not None}
    by_seed = [{"seed": seed} | errors for seed, errors in model.by_seed.items()]
    return figures | ({} if model.spread is None else {"spread": model.spread, "seeds": by_seed})


def _cells(model: Any) -> tuple[str, ...]:
    """Of AblationFigures."""
    row = model.mean
    spread = {} if model.spread is None else {name: f" ± {value:.3f}" for name, value in model.spread.items()}
    errors = (f"{getattr(row, name):.3f}{spread.get(name, '')}" for name in ("train", "test", "surface"))
    regularised = "-" if row.latent_weight is None else f"{row.latent_weight:g}"
    return (row.name, f"{row.parameters:,}", *errors, f"{row.seconds:.0f}", regularised)
