"""Changing a face: labels, caricature, points pulled, expressions."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from caricli.errors import InputError, shown
from caricli.methods.edit.caricaturize_face import LABEL, caricaturize_face
from caricli.methods.edit.edit_handles import edit_handles
from caricli.methods.edit.edit_semantic import STRONGEST, SemanticEdit, edit_semantic
from caricli.methods.edit.handle_points import handle_points
from caricli.methods.edit.settings import MODES
from caricli.methods.session.parameters import Parameters, choice, number, numbers, only, switch, texts
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures.arkit import ARKIT_NAMES

_MOST_HANDLES = 200
_NEARLY = 0.95
"""Share of a handle's way of which nothing is said."""

_MOST_STRENGTH = 10.0
"""As of ``caricli caricaturize``."""


def semantic(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """More or less of labels, as ``caricli edit-semantic``.

    strengths: standard deviations by label. keep: labels that do not change.
    """
    only(parameters, "strengths", "keep")
    strengths = numbers(parameters, "strengths", STRONGEST)
    edit = SemanticEdit(tools.directions, strengths, texts(parameters, "keep"))
    face = edit_semantic(work.face, tools.model, edit)
    return replace(work, face=face, strengths=_added(work.strengths, strengths))


def caricaturize(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Exaggerate, as ``caricli caricaturize``. strength: from 0. mode: "direction" or "own"."""
    only(parameters, "strength", "mode")
    strength = number(parameters, "strength", 0, _MOST_STRENGTH)
    mode = choice(parameters, "mode", MODES, "direction")
    face = caricaturize_face(work.face, tools.model, strength, mode, tools.directions)
    added = {LABEL: strength} if mode == "direction" else {}
    return replace(work, face=face, strengths=_added(work.strengths, added))


def handle(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """Pull points of the face, as ``caricli edit-handle``.

    handles: rows [dx, dy, dz] in metres, or shares such as "5%", by vertex or name. pins: places that stay. symmetric:
    whether the other side does the same.
    """
    only(parameters, "handles", "pins", "symmetric")
    given = parameters.get("handles")
    if not isinstance(given, dict) or not 0 < len(given) <= _MOST_HANDLES:
        raise InputError(f"handles: expected 1 to {_MOST_HANDLES} places with lengths, found {shown(repr(given), 60)}")
    head = tools.model.template.with_vertices(work.face.vertices)
    pins = texts(parameters, "pins", _MOST_HANDLES)
    handles = handle_points(list(given.items()), pins, head, switch(parameters, "symmetric"))
    edit = edit_handles(work.face, tools.model, handles)
    least = float(np.nanmin(edit.reached))
    remark = "" if least > _NEARLY else f"{100 * least:.0f} % of the way: the model knows no such face"
    return replace(work, face=edit.face, remark=remark)


def expression(work: Work, parameters: Parameters, tools: Tools) -> Work:
    """What the face does; its shape at rest stays. weights: 0 to 1, by ARKit's names; others stay as they are."""
    only(parameters, "weights")
    weights = numbers(parameters, "weights", 1)
    for name, weight in weights.items():
        if name not in ARKIT_NAMES:
            raise InputError(f"weights: expected names of ARKit's, such as jawOpen, found {shown(name, 60)!r}")
        if weight < 0:
            raise InputError(f"{name}: expected a weight from 0 to 1, found {weight:g}")
    together = {**work.weights, **weights}
    return replace(work, weights={name: together[name] for name in ARKIT_NAMES if together.get(name)})


def _added(before: Mapping[str, float], more: Mapping[str, float]) -> dict[str, float]:
    """Strengths by label, those that are not 0."""
    sums = {name: before.get(name, 0) + more.get(name, 0) for name in {**before, **more}}
    return {name: total for name, total in sums.items() if round(total, 6)}


FACE_OPERATIONS = {"semantic": semantic, "caricaturize": caricaturize, "handle": handle, "expression": expression}
"""By name."""
