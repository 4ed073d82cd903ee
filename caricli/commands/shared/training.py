"""What commands share that train networks."""

from pathlib import Path

import click
import numpy as np

from caricli.errors import InputError
from caricli.template.template import Template


def chosen_device(device: str) -> str:
    """The name for PyTorch of what --device asks for: auto, cpu or cuda."""
    import torch

    if device == "cuda" and not torch.cuda.is_available():
        raise InputError("--device cuda: this machine has no CUDA device that PyTorch can use")
    return ("cuda" if torch.cuda.is_available() else "cpu") if device == "auto" else device


def network_points(template: Template, path: Path | None = None) -> np.ndarray:
    """(V, 3) the shape that a network deforms, as of ``load_network_points``; say so where parts of it touch."""
    from caricli.methods.train.deformable.train_deformable import touching_vertices
    from caricli.store.network_points import load_network_points

    points = load_network_points(template, path)
    touching = touching_vertices(points)
    if touching:
        note = f"caricli: {touching} vertices lie on others, which the network cannot tell apart; see --template"
        click.echo(note, err=True)
    return points
