"""caricli evaluate ablation: what each choice of the deformable model is worth."""

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
from caricli.errors import shown
from caricli.io.config import read_config
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder, write_bytes
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

_COLUMNS = ("model", "parameters", "train %", "test %", "test surface %", "training s", "λ_reg")


@click.command()
@data_option
@out_option("DIR", "Write ablation.png, ablation.json and ablation.md into this folder.")
@config_option
@set_option
@device_option
@overwrite_option
def command(dataset, out, config, overrides, device, overwrite):
    """Train the deformable model beside its rivals on the same meshes and compare their errors.

    The rivals are arrays of vertex positions and displacements, a SIREN that takes the latent as a further input,
    training without points between the vertices, PCA and the intrinsic model. DIR gets ablation.png (errors of four
    networks during the training: on training meshes every epoch, on test meshes whose codes follow it at every
    validation), ablation.md and ablation.json (the table, at the end, when the test codes are fitted to the last).

    \b
    Example:
      caricli evaluate ablation --data dataset --out ablation
      caricli evaluate ablation --data dataset --out ablation --set start=principal
    """
    from caricli.commands.shared.progress import progress_bar
    from caricli.commands.shared.tables import print_table
    from caricli.commands.shared.training import chosen_device, network_points
    from caricli.data.dataset import read_dataset
    from caricli.methods.evaluate.evaluate_ablation import NETWORKS, ablation_meshes, evaluate_ablation
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
        recipe = provenance("evaluate ablation", [dataset / "dataset.json"], settings.seed, config=asdict(settings))
        meshes = ablation_meshes(data, network_points(data.template), settings, place)
        rows = list(evaluate_ablation(data.template, meshes, settings, report))
        _write(folder, rows, recipe | {"meshes": len(meshes.shapes), "unseen": len(meshes.unseen)})
    print_table(_COLUMNS, map(_cells, rows))
    echo_result(f"{shown(out)}: {len(rows)} networks")


def _write(folder: Path, rows: list, recipe: dict) -> None:
    """Write AblationRows as JSON and Markdown, and their curves."""
    from caricli.methods.evaluate.evaluate_ablation import DRAWN
    from caricli.render.plot_curves import plot_curves

    models = [{key: value for key, value in asdict(row).items() if value is not None} for row in rows]
    write_json(folder / "ablation.json", recipe | {"models": models})
    lines = [_COLUMNS, ["---"] * len(_COLUMNS), *map(_cells, rows)]
    write_bytes(folder / "ablation.md", "".join(f"| {' | '.join(line)} |\n" for line in lines).encode())
    drawn = {row.name: row.curves for row in rows if row.name in DRAWN}
    panels = {
        f"{split} error": {name: tuple(zip(*curves[split], strict=True)) for name, curves in drawn.items()}
        for split in ("train", "test")
    }
    write_png(folder / "ablation.png", plot_curves(panels))


def _cells(row: Any) -> tuple[str, ...]:
    """Of an AblationRow."""
    errors = (f"{error:.3f}" for error in (row.train, row.test, row.surface))
    regularised = "-" if row.latent_weight is None else f"{row.latent_weight:g}"
    return (row.name, f"{row.parameters:,}", *errors, f"{row.seconds:.0f}", regularised)
