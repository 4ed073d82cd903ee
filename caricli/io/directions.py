"""Directions of semantic labels in the latent space of a model: NPZ by schema."""

from dataclasses import dataclass, fields

import numpy as np

from caricli.errors import InputError, OutputError
from caricli.io.files import shown
from caricli.io.npz import read_npz, text_of, write_npz
from caricli.io.strict_json import format_json, parse_json

SCHEMA = "caricli.directions/1"

_STORED = {
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
_UNIT = 1e-3


@dataclass(frozen=True, eq=False)
class Directions:
    """Where labels lie in the whitened latents (mean 0, standard deviation 1) of a model.

    names (A,), distinct; normals (A, D), unit vectors towards the meshes with the label; gradients (A, D), change of
    the label's measure, in its standard deviations, by the whitened latent, 0 where there is no measure; auc (A,),
    cross-validated; positives (A,) meshes with the label among count; cost (A,), the C of the support vector machines;
    change (A,) of the measure, in its standard deviations, along one standard deviation of the normal, 0 where there is
    no measure; model_id, text; recipe, dict, as `provenance` makes it; people (I, D), whitened latents of the most
    regular face of everybody among the test meshes, to tell whether an edited face is still nearest to its own.
    """

    names: tuple
    normals: np.ndarray
    gradients: np.ndarray
    auc: np.ndarray
    positives: np.ndarray
    count: int
    cost: np.ndarray
    change: np.ndarray
    model_id: str
    recipe: dict
    people: np.ndarray


def read_directions(path):
    """Read directions.

    Parameters: path of a file that `write_directions` wrote.
    Returns: Directions, floats as float64, normals of unit length.
    Raises: InputError when the file is malformed, a shape or the schema differs, a value is not finite or out of range.
    """
    arrays = read_npz(path)
    if text_of(arrays.pop("schema", None)) != SCHEMA:
        raise InputError(f"{shown(path)}: expected directions with schema {SCHEMA!r}, found another or none")
    if set(arrays) != set(_STORED):
        odd = min(set(arrays) ^ set(_STORED))
        found = "it" if odd in arrays else "none"
        raise InputError(f"{shown(path)}: expected the arrays of directions, with {shown(odd, 60)!r} found {found}")
    for key, stored in _STORED.items():
        if arrays[key].dtype.kind != np.dtype(stored).kind:
            raise InputError(f"{shown(path)}: {key}: expected {np.dtype(stored).name}, found {arrays[key].dtype}")
    values = {key: a.astype(float) if a.dtype.kind == "f" else a for key, a in arrays.items()}
    problem = _problem(values)
    if problem:
        raise InputError(f"{shown(path)}: {problem}")
    recipe = parse_json(values["recipe"].item().encode(), f"{shown(path)}: recipe")
    if not isinstance(recipe, dict):
        raise InputError(f"{shown(path)}: recipe: expected an object, found {type(recipe).__name__}")
    values["normals"] /= np.linalg.norm(values["normals"], axis=1, keepdims=True)
    names, texts = tuple(values["names"].tolist()), {"model_id": values["model_id"].item(), "recipe": recipe}
    return Directions(**values | texts | {"names": names, "count": int(values["count"])})


def write_directions(path, directions):
    """Write directions, floats in single precision; the same directions give the same bytes.

    Parameters: path; directions, Directions.
    Raises: OutputError when they could not be read back or the file cannot be written.
    """
    values = {field.name: getattr(directions, field.name) for field in fields(directions)}
    values["recipe"] = format_json(directions.recipe, path, indent=None).strip()
    arrays = {key: np.asarray(value, _STORED[key]) for key, value in values.items()}
    problem = _problem(arrays)
    if problem:
        raise OutputError(f"{shown(path)}: {problem}")
    write_npz(path, {"schema": np.array(SCHEMA)} | arrays)


def _problem(values):
    """Return what is wrong as "key: expected ..., found ...", or None."""
    names, normals = values["names"], values["normals"]
    if names.ndim != 1 or not len(names) or not all(names) or len(set(names.tolist())) < len(names):
        return f"names: expected a list of distinct names, found {names.shape} {shown(names.tolist(), 60)}"
    if normals.ndim != 2 or 0 in normals.shape:
        return f"normals: expected (A,D), found {normals.shape}"
    shapes = dict.fromkeys(("names", "auc", "positives", "cost", "change"), normals.shape[:1])
    shapes |= dict.fromkeys(("count", "model_id", "recipe"), ()) | {"gradients": normals.shape}
    shapes |= {"people": (len(values["people"]) if values["people"].ndim else 0, normals.shape[1])}
    for key, shape in shapes.items():
        if values[key].shape != shape:
            return f"{key}: expected the shape {shape}, found {values[key].shape}"
    for key in ("normals", "gradients", "auc", "cost", "change", "people"):
        if not np.isfinite(values[key]).all():
            return f"{key}: expected finite numbers, found others"
    lengths = np.linalg.norm(normals.astype(float), axis=1)
    if np.abs(lengths - 1).max() > _UNIT:
        return f"normals: expected unit vectors, found lengths from {lengths.min():.3g} to {lengths.max():.3g}"
    if values["auc"].min() < 0 or values["auc"].max() > 1:
        return "auc: expected numbers from 0 to 1, found others"
    if values["positives"].min() < 0 or values["positives"].max() > values["count"]:
        return f"positives: expected numbers from 0 to {values['count']}, found others"
    if not values["model_id"].item():
        return "model_id: expected text, found none"
    return None
