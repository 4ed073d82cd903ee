"""Shape models to plain tensors with a description, and back."""

import hashlib
from importlib import import_module

import numpy as np

from caricli.errors import InputError
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

SCHEMA = "caricli.model/1"
KINDS = ("pca", "intrinsic", "kernel", "deformable", "morphable")
_TEMPLATE = ("vertices", "faces", "polygons", "uvs", "uv_polygons")


def model_class(kind):
    """The class of a kind, imported only when it is asked for: not every kind needs torch."""
    return getattr(import_module(f"caricli.models.{kind}.model"), f"{kind.capitalize()}Model")


def model_to_checkpoint(model, recipe):
    """A model as (tensors, metadata), from which ``model_from_checkpoint`` rebuilds it.

    model: ShapeModel. recipe: JSON value, how it was trained.
    """
    tensors = {f"model.{name}": value for name, value in model.tensors().items()}
    for name in _TEMPLATE:
        value = getattr(model.template, name)
        if value is not None:
            tensors[f"template.{name}"] = value.astype(np.int32 if value.dtype.kind == "i" else np.float64)
    annotation = model.template.annotation.source
    return tensors, {"schema": SCHEMA, "kind": model.kind, "annotation": annotation, "recipe": recipe}


def model_from_checkpoint(tensors, metadata, where):
    """Rebuild a ShapeModel.

    tensors, metadata: of ``model_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit.
    """
    if metadata.get("schema") != SCHEMA:
        raise InputError(f"{where}: expected a model of schema {SCHEMA!r}, found {metadata.get('schema')!r}")
    if metadata.get("kind") not in KINDS:
        raise InputError(f"{where}: expected a model of kind {' or '.join(KINDS)}, found {metadata.get('kind')!r}")
    for name, value in tensors.items():
        if not np.isfinite(value).all():
            raise InputError(f"{where}: {name} must be finite")
    try:
        parts = {name: tensors[f"template.{name}"] for name in _TEMPLATE[:3]}
        parts |= {name: tensors.get(f"template.{name}") for name in _TEMPLATE[3:]}
        count = len(parts["vertices"])
        _check_template(parts, count, where)
        annotation = parse_annotation(metadata["annotation"], count, where)
        parts["vertices"] = parts["vertices"].astype(np.float64)
        faces = parts.pop("faces")
        template = Template(**parts, annotation=annotation)
        if not np.array_equal(template.faces, faces):
            raise InputError(f"{where}: its template is not a mesh")
        own = {name.removeprefix("model."): value for name, value in tensors.items() if name.startswith("model.")}
        return model_class(metadata["kind"]).from_tensors(template, own, model_id(metadata["kind"], own))
    except (KeyError, ValueError, IndexError, TypeError, np.linalg.LinAlgError) as error:
        raise InputError(f"{where}: not a valid model: {type(error).__name__} {error}") from error


def model_id(kind, tensors):
    """SHA-256 of a model's own tensors: the same for the file and for the model in memory."""
    digest = hashlib.sha256(kind.encode())
    for name in sorted(tensors):
        value = tensors[name].astype("<f4")
        digest.update(f"{name}{value.shape}".encode() + value.tobytes())
    return digest.hexdigest()


def _check_template(parts, count, where):
    faces, polygons, uvs, uv_polygons = (parts[name] for name in _TEMPLATE[1:])
    fits = (
        parts["vertices"].shape == (count, 3)
        and all(part is None or part.dtype.kind in "iu" for part in (faces, polygons, uv_polygons))
        and faces.ndim == polygons.ndim == 2
        and faces.shape[1] == 3
        and 0 <= faces.min() <= faces.max() < count
        and -1 <= polygons.min() <= polygons.max() < count
        and (uvs is None) == (uv_polygons is None)
        and (uvs is None or (uvs.ndim == 2 and uvs.shape[1] == 2 and uv_polygons.shape == polygons.shape))
        and (uvs is None or -1 <= uv_polygons.min() <= uv_polygons.max() < len(uvs))
    )
    if not fits:
        raise InputError(f"{where}: its template is not a mesh")
