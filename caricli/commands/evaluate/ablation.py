"""caricli evaluate ablation: what each choice of the deformable model is worth."""

from dataclasses import asdict

import click

from caricli.commands.shared.options import (
    config_option,
    data_option,
    device_option,
    out_option,
    overwrite_option,
    set_option,
)
from caricli.errors import InputError
from caricli.io.config import read_config
from caricli.io.image import write_png
from caricli.io.outputs import staged_folder, write_bytes
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json

_COLUMNS = ("model", "parameters", "train %", "test %", "test surface %", "training s")


@click.command()
@data_option
@out_option("DIR", "A folder for the figure and the table as PNG, JSON and Markdown.")
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
    from rich.console import Console
    from rich.table import Table

    from caricli.commands.shared.progress import progress_bar
    from caricli.commands.train.deformable import chosen_device, network_points
    from caricli.data.dataset import read_dataset
    from caricli.methods.evaluate.evaluate_ablation import NETWORKS, evaluate_ablation
    from caricli.models.ablation.networks import AblationConfig
    from caricli.models.deformable.model import Frame
    from caricli.store.datasets import dataset_files

    settings, device = read_config(config, AblationConfig, overrides), chosen_device(device)
    inputs = (dataset, config, *dataset_files(dataset))
    with (
        staged_folder(out, overwrite=overwrite, inputs=inputs, marker="ablation.json") as folder,
        progress_bar(f"training {len(NETWORKS)} networks") as report,
    ):
        data = read_dataset(dataset)
        recipe = provenance("evaluate ablation", [dataset / "dataset.json"], settings.seed, config=asdict(settings))
        meshes = _meshes(data, "train", settings.meshes, 3), _meshes(data, "test", settings.unseen, 1)
        frame = Frame(network_points(data.template))
        rows = list(evaluate_ablation(data.template, frame, *meshes, settings, device, report))
        _write(folder, rows, recipe | {"meshes": len(meshes[0]), "unseen": len(meshes[1])})
    table = Table(*_COLUMNS)
    for row in rows:
        table.add_row(*_cells(row))
    Console(width=None if Console().is_terminal else 120).print(table)


def _meshes(data, split, count, least):
    from caricli.methods.evaluate.evaluate_shape import spread_rows

    rows = data.rows(split)
    if rows.sum() < least:
        raise InputError(f"the dataset's {split} split has {rows.sum()} meshes, at least {least} are needed")
    return data.vertices[spread_rows(rows, count or len(rows))]


def _write(folder, rows, recipe):
    from caricli.methods.evaluate.evaluate_ablation import VERTICES_ONLY
    from caricli.render.plot_curves import plot_curves

    models = [{key: value for key, value in asdict(row).items() if value is not None} for row in rows]
    write_json(folder / "ablation.json", recipe | {"models": models})
    lines = [_COLUMNS, ["---"] * len(_COLUMNS), *map(_cells, rows)]
    write_bytes(folder / "ablation.md", "".join(f"| {' | '.join(line)} |\n" for line in lines).encode())
    drawn = {row.name: row.curves for row in rows if row.curves and row.name != VERTICES_ONLY}
    panels = {
        f"{split} error": {name: list(zip(*curves[split], strict=True)) for name, curves in drawn.items()}
        for split in ("train", "test")
    }
    write_png(folder / "ablation.png", plot_curves(panels))


def _cells(row):
    errors = (f"{error:.3f}" for error in (row.train, row.test, row.surface))
    return row.name, f"{row.parameters:,}", *errors, f"{row.seconds:.0f}"
