"""Directions of semantic labels in the latent space of a model: NPZ by schema."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from caricli.errors import InputError, OutputError, naming, shown
from caricli.io.npz import read_npz, take_texts, write_npz
from caricli.io.strict_json import format_json, parse_json
from caricli.structures import Directions

SCHEMA = "caricli.directions/1"

_STORED: dict[str, type] = {
    "names": np.str_,
    "normals": np.float32,
    "gradients": np.float32,
    "auc": np.float32,
    "positives": np.int32,
    "count": np.int32,
    "cost": np.float32,
    "change": np.float32,
    "model_id": np.str_,
    "recipe": np.str_,
    "people": np.float32,
}


def read_directions(path: str | Path) -> Directions:
    """Read directions that ``write_directions`` wrote; floats as float64, normals of unit length.

    Raises InputError when the file is malformed, a shape or the schema differs, a value is not finite or out of range.
    """
    arrays = read_npz(path)
    with naming(path):
        take_texts(arrays, {"schema": SCHEMA}, "directions")
        return _directions(arrays)


def write_directions(path: str | Path, directions: Directions) -> None:
    """Write directions, floats in single precision; the same directions give the same bytes.

    Raises OutputError when they name no model or the file cannot be written.
    """
    if not directions.model_id:
        raise OutputError(f"{shown(path)}: model_id: expected text, found none")
    values = {key: getattr(directions, key) for key in _STORED}
    values["recipe"] = format_json(directions.recipe, path, indent=None).strip()
    arrays: dict[str, np.ndarray] = {key: np.array(value, _STORED[key]) for key, value in values.items()}
    write_npz(path, {"schema": np.array(SCHEMA)} | arrays)


def _directions(arrays: dict) -> Directions:
    if set(arrays) != set(_STORED):
        odd = min(set(arrays) ^ set(_STORED))
        state = "it" if odd in arrays else "none"
        raise InputError(f"expected the arrays of directions, with {shown(odd, 60)!r} found {state}")
    for key, stored in _STORED.items():
        if arrays[key].dtype.kind != np.dtype(stored).kind:
            raise InputError(f"{key}: expected {np.dtype(stored).name}, found {arrays[key].dtype}")
    for key in ("count", "model_id", "recipe"):
        if arrays[key].ndim:
            raise InputError(f"{key}: expected the shape (), found {arrays[key].shape}")
    values = {key: array.astype(float) if array.dtype.kind == "f" else array for key, array in arrays.items()}
    recipe = parse_json(values["recipe"].item().encode(), "recipe")
    if not isinstance(recipe, dict):
        raise InputError(f"recipe: expected an object, found {type(recipe).__name__}")
    if not values["model_id"].item():
        raise InputError("model_id: expected text, found none")
    names = tuple(values["names"].tolist()) if values["names"].ndim == 1 else ()
    plain = {"names": names, "count": int(values["count"]), "model_id": values["model_id"].item(), "recipe": recipe}
    directions = Directions(**values | plain)
    # Single precision leaves them a little off.
    lengths = np.linalg.norm(directions.normals, axis=1, keepdims=True)
    return replace(directions, normals=directions.normals / lengths)
