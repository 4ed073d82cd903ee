"""Directions of labels by path, or those that come with caricli."""

from caricli.errors import InputError, shown
from caricli.io.bundled import asset_path
from caricli.io.directions import read_directions
from caricli.store.models import model_name


def directions_path(path, model):
    """The file of directions that was given, or the bundled one of the model's kind."""
    path = asset_path(f"directions-{model.kind}.npz") if path is None else path
    if not path.is_file() and path.parent == asset_path(""):
        raise InputError(f"there are no bundled directions for {model.kind} models; give --directions")
    return path


def load_directions(path, model):
    """The Directions of a file, refused when they are not of the model."""
    directions = read_directions(path)
    if directions.model_id != model.model_id:
        raise InputError(
            f"{shown(path)}: its directions are of {model_name(directions.model_id)}, not of "
            f"{model_name(model.model_id)}; make them with caricli train semantic and give --directions"
        )
    if directions.normals.shape[1] != len(model.prior.mean):
        found = directions.normals.shape[1]
        raise InputError(f"{shown(path)}: expected directions of {len(model.prior.mean)} numbers, found {found}")
    return directions
