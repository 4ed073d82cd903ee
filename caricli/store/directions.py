"""Directions of labels by path, or those that come with caricli."""

from pathlib import Path

from caricli.errors import InputError, shown
from caricli.io.bundled import asset_path
from caricli.io.directions import read_directions
from caricli.models.shape_model import ShapeModel
from caricli.store.models import model_name
from caricli.structures import Directions


def directions_path(path: Path | None, model: ShapeModel) -> Path:
    """The file of directions that was given, or the bundled one of the model's kind.

    Raises InputError where there is none for models of this kind.
    """
    path = asset_path(f"directions-{model.kind}.npz") if path is None else path
    if not path.is_file() and path.parent == asset_path(""):
        raise InputError(f"there are no bundled directions for {model.kind} models; give --directions")
    return path


def load_directions(model: ShapeModel, path: Path | None = None) -> Directions:
    """The directions of labels in the latents of a model.

    path: of a file that `caricli train semantic` wrote; None for the bundled one of the model's kind.
    Raises InputError when they are not of the model, or the file holds none.
    """
    path = directions_path(path, model)
    directions = read_directions(path)
    if directions.model_id != model.model_id:
        raise InputError(
            f"{shown(path)}: its directions are of {model_name(directions.model_id)}, not of "
            f"{model_name(model.model_id)}; make them with caricli train semantic and give --directions"
        )
    dimension = len(model.prior.mean)
    if directions.normals.shape[1] != dimension:
        count = directions.normals.shape[1]
        raise InputError(f"{shown(path)}: expected directions of {dimension} numbers, found {count}")
    return directions
