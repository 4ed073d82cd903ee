"""Templates of expressions: the open head's, or a folder of meshes."""

import math
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from caricli.data.expressions import NEUTRAL
from caricli.data.mesh_names import expression_name
from caricli.errors import InputError, naming, shown
from caricli.io.bundled import asset_path
from caricli.io.meshes.mesh import mesh_files, read_mesh
from caricli.io.strict_json import read_json
from caricli.methods.rig.expression_templates import ExpressionTemplates, check_templates
from caricli.methods.rig.head_expressions import open_head_expressions
from caricli.store.models import load_model
from caricli.structures import Mesh
from caricli.structures.arkit import arkit_name, is_half, plain_name
from caricli.template.template import Template

_FARTHEST = 0.1
"""Of the head's height: no expression moves half of a head so far."""


def load_templates(folder: Path | None = None, model: Path | None = None) -> tuple[ExpressionTemplates, list[Path]]:
    """ExpressionTemplates, and the files that they are read from.

    folder: path of one with meshes, or None for the open head's own. A file whose name means an action of ARKit's
    (``eyeBlink_L``) gets its name; halves of one (``browInnerUp_L``) keep theirs, and where both are there, their sum
    is added as the whole. model: path of a model of their mesh, which knows its vertices by name; or None.
    Raises InputError where it holds no neutral face and expressions of one mesh that can be transferred from, and for a
    model of another mesh.
    """
    if folder is None:
        return open_head_expressions(), []
    neutral_path, others = _template_files(folder)
    neutral = read_mesh(neutral_path)
    shapes = np.stack([_shape_of(path, neutral) for path in others])
    with naming(folder):
        names, shapes = _with_arkit_names([path.stem for path in others], neutral.vertices, shapes)
    with naming(neutral_path):
        templates = check_templates(names, neutral, shapes)
    files = sorted([neutral_path, *others])
    if model is None:
        return templates, files
    template = load_model(model).template
    with naming(model):
        templates.require_topology(template)
    return on_template(templates, template), [*files, model]


def on_template(actions: ExpressionTemplates, template: Template) -> ExpressionTemplates:
    """The same templates in metres, with what is known by name on the mesh of a model."""
    unit = 10.0 ** round(math.log10(template.height / actions.mesh.height))
    return replace(actions, mesh=template.with_vertices(unit * actions.neutral), deltas=unit * actions.deltas)


def load_action_units() -> dict[str, dict]:
    """What FACS says of ARKit's actions by name: ``action_units``, and the ``facs46`` that they are, or None."""
    return read_json(asset_path("facs.json"))


def _template_files(folder: Path) -> tuple[Path, list[Path]]:
    """The neutral mesh of a folder and the others, in the order of their names."""
    if not folder.is_dir():
        raise InputError(f"{shown(folder)}: expected a folder with {NEUTRAL}.obj and expressions, found none")
    files = mesh_files(folder)
    names = [path.stem.lower() for path in files]
    (name, count), *_ = Counter(names).most_common(1) or [("", 0)]
    if count > 1:
        raise InputError(f"{shown(folder)}: expected distinct names, found {name!r} twice")
    if NEUTRAL not in names or len(files) < 2:
        raise InputError(f"{shown(folder)}: expected {NEUTRAL}.obj and expressions, found {len(files)} other meshes")
    neutral = files[names.index(NEUTRAL)]
    return neutral, [path for path in files if path != neutral]


def _with_arkit_names(names: list[str], neutral: np.ndarray, shapes: np.ndarray) -> tuple[list[str], np.ndarray]:
    """Names by ARKit's where they mean the same, and shapes (K, V, 3), the wholes of two halves appended to both."""
    own = [expression_name(name) for name in names]
    (twice, count), *_ = Counter(own).most_common(1)
    if count > 1:
        raise InputError(f"expected distinct expressions, found {twice!r} twice under two names")
    halves = {name: arkit_name(name) for name in own if is_half(name)}
    sides = {plain_name(name) for name in halves}
    wholes = [
        whole
        for whole in dict.fromkeys(halves.values())
        if whole and whole not in own and {plain_name(whole + side) for side in ("Left", "Right")} <= sides
    ]
    sums = [
        neutral + sum(shapes[k] - neutral for k, name in enumerate(own) if halves.get(name) == whole)
        for whole in wholes
    ]
    return [*own, *wholes], np.array([*shapes, *sums])


def _shape_of(path: Path, neutral: Mesh) -> np.ndarray:
    """Vertices (V, 3) of a file, refused when it is another mesh than the neutral one's."""
    mesh = read_mesh(path)
    if mesh.vertices.shape != neutral.vertices.shape or not np.array_equal(mesh.polygons, neutral.polygons):
        counts = f"{len(mesh.vertices)} vertices and {len(mesh.polygons)} polygons"
        raise InputError(f"{shown(path)}: expected the mesh of {NEUTRAL}.obj, found another ({counts})")
    away = np.median(np.linalg.norm(mesh.vertices - neutral.vertices, axis=1)) / neutral.height
    if away > _FARTHEST:
        raise InputError(
            f"{shown(path)}: expected a face in the unit and the place of {NEUTRAL}.obj, found one half of whose "
            f"vertices are {100 * away:.0f} % of the head's height away"
        )
    return mesh.vertices
