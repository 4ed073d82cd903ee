"""Shape models to plain tensors with a description, and back."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.models.kinds import KINDS, model_class
from caricli.models.model_id import model_id
from caricli.models.shape_model import ShapeModel
from caricli.structures import SeenPeople
from caricli.structures.checks import number_problem, refuse
from caricli.template.annotation import parse_annotation
from caricli.template.own_parts import parts_from_arrays, parts_to_arrays
from caricli.template.template import Template

SCHEMA = "caricli.model/1"
_NO_MESH = "its template is not a mesh"


def model_to_checkpoint(model: ShapeModel, recipe: Any) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A model as (tensors, metadata), from which ``model_from_checkpoint`` rebuilds it.

    recipe: JSON value, how it was trained.
    """
    tensors = {f"model.{name}": value for name, value in model.tensors().items()}
    for name in ("vertices", "faces", "polygons", "uvs", "uv_polygons"):
        value = getattr(model.template, name)
        if value is not None:
            tensors[f"template.{name}"] = value.astype(np.int32 if value.dtype.kind == "i" else np.float64)
    for name, value in parts_to_arrays(model.template.parts).items():
        tensors[f"template.{name}"] = value.astype(np.int32 if value.dtype.kind == "i" else np.float64)
    annotation = model.template.annotation.source
    return tensors, {"schema": SCHEMA, "kind": model.kind, "annotation": annotation, "recipe": recipe}


def model_from_checkpoint(tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object) -> ShapeModel:
    """Rebuild a ShapeModel.

    tensors, metadata: of ``model_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit, NumericsError for a template that cannot be solved on.
    """
    with naming(where):
        if metadata.get("schema") != SCHEMA:
            raise InputError(f"expected a model of schema {SCHEMA!r}, found {shown(metadata.get('schema'), 60)!r}")
        kind = metadata.get("kind")
        if not isinstance(kind, str) or kind not in KINDS:
            raise InputError(f"expected a model of kind {' or '.join(KINDS)}, found {shown(kind, 60)!r}")
        for name, value in tensors.items():
            refuse(number_problem(shown(name, 60), value))
    try:
        template = _shared_template(tensors, metadata["annotation"], where)
        own = own_tensors(tensors)
        with naming(where):
            model = model_class(kind).from_tensors(template, own)
            # The same as of its own tensors, which takes five times as long.
            vars(model)["model_id"] = model_id(kind, own)
        more = {*tensors} - {f"model.{name}" for name in model.tensors()}
        if more := {name for name in more if not name.startswith("template.")}:
            raise ValueError(f"with {min(more)}, which is of no {kind} model")
    except KeyError as error:
        raise InputError(f"{shown(where)}: not a valid model: without {shown(error, 60)}") from error
    except (ValueError, IndexError, TypeError) as error:
        raise InputError(f"{shown(where)}: not a valid model: {shown(error, 200)}") from error
    with naming(where):
        model.seen = SeenPeople.of_recipe(metadata.get("recipe"))
    return model


def own_tensors(tensors: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What a checkpoint's tensors say of the model itself, as it names them; the others are its template's."""
    return {name.removeprefix("model."): value for name, value in tensors.items() if name.startswith("model.")}


_templates: WeakValueDictionary[str, Template] = WeakValueDictionary()
"""Those of the models that are in use, by what they are made of."""


def _shared_template(tensors: Mapping[str, np.ndarray], annotation: Any, where: object) -> Template:
    """The Template of a model; models of the same one share it, and what is factored for it."""
    digest = hashlib.sha256(json.dumps(annotation).encode())
    for name in sorted(tensors):
        if name.startswith("template."):
            value = np.ascontiguousarray(tensors[name])
            digest.update(f"{name}{value.shape}{value.dtype}".encode())
            digest.update(value.data)
    key = digest.hexdigest()
    template = _templates.get(key)
    if template is None:
        template = _template(tensors, annotation, where)
        _templates[key] = template
    return template


def _template(tensors: Mapping[str, np.ndarray], annotation: Any, where: object) -> Template:
    vertices = tensors["template.vertices"].astype(np.float64)
    faces = tensors["template.faces"]
    polygons = tensors["template.polygons"]
    uvs = tensors.get("template.uvs")
    uv_polygons = tensors.get("template.uv_polygons")
    tables = [table for table in (faces, polygons, uv_polygons) if table is not None]
    with naming(where):
        if any(table.dtype.kind not in "iu" for table in tables):
            raise InputError(_NO_MESH)
    parsed = parse_annotation(annotation, len(vertices), shown(where))
    with naming(f"{shown(where)}: {_NO_MESH}"):
        template = Template(vertices, polygons, uvs, uv_polygons, annotation=parsed)
    with naming(where):
        if not np.array_equal(template.faces, faces):
            raise InputError(_NO_MESH)
        own = {name.removeprefix("template."): value for name, value in tensors.items()}
        return replace(template, parts=parts_from_arrays(own, template))
