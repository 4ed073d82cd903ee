"""Teeth, tongue and lashes of the open head."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from caricli.geometry.alignment.similarity import similarity
from caricli.structures import Material
from caricli.structures.head_choice import Teeth
from caricli.structures.parts import Hold, Part
from caricli.template.dental_arch import STYLES, dental_arch
from caricli.template.head import BasePart, Head
from caricli.template.lash_hairs import lash_hairs

WAY_OUT = {
    "jawOpen": 0.2,
    "mouthLowerDownLeft": 0.5,
    "mouthLowerDownRight": 0.5,
    "mouthUpperUpLeft": 0.4,
    "mouthUpperUpRight": 0.4,
}
"""Weights of the actions that let the tongue out: the base mesh pushes it through closed lips."""

RAISED = 0.006
"""Metres that the tongue comes out higher than in the base mesh, over the lower lip instead of through it."""

FLAT = 0.75
"""Of its height: what it keeps on its way out."""

_STILL = 1e-6
"""Metres: what an action moves less it does not move."""


def head_parts(head: Head, style: Teeth = "natural", **options: Any) -> tuple[Part, ...]:
    """The parts of ``head.evaluate(**options)``, moved by the 52 ARKit actions.

    Teeth are modelled on the bands of the base mesh and move as rigidly as bone; lashes are single hairs along its
    strips; the tongue is the base mesh's own.

    style: a key of ``dental_arch.STYLES``.
    """
    teeth = [_teeth(head.parts[f"teeth_{row}"], row, style, options) for row in ("upper", "lower")]
    return (*teeth, _tongue(head.parts["tongue"], options), _lashes(head.parts["lashes"], options))


def _teeth(band: BasePart, row: str, style: Teeth, options: dict[str, Any]) -> Part:
    place = band.mesh(**options)
    mesh, materials = dental_arch(place, row == "upper", STYLES[style])
    deltas = np.zeros((len(band.action_names), *mesh.vertices.shape))
    for k, (name, moved) in enumerate(zip(band.action_names, band.actions.astype(float), strict=True)):
        moved = moved + (part_lips(band.action_names, band.actions) if name == "tongueOut" else 0)
        if np.abs(moved).max() > _STILL:
            _, rotation, translation = similarity(place.vertices, place.vertices + moved, scaling=False)
            deltas[k] = mesh.vertices @ rotation.T + translation - mesh.vertices
    hold: Hold = "skull" if row == "upper" else "jaw"
    return Part(f"teeth_{row}", mesh, materials, hold, band.action_names, deltas)


def part_lips(names: Sequence[str], deltas: np.ndarray) -> np.ndarray:
    """(V, 3) what lets the tongue out does to a mesh, of what actions do to it. names: K. deltas: (K, V, 3)."""
    return sum((weight * deltas[names.index(name)] for name, weight in WAY_OUT.items()), np.zeros(deltas.shape[1:]))


def _tongue(tongue: BasePart, options: dict[str, Any]) -> Part:
    mesh = tongue.mesh(**options)
    materials = np.full(len(mesh.polygons), Material.TONGUE, np.int32)
    deltas = tongue.actions.astype(float)
    out = deltas[tongue.action_names.index("tongueOut")]
    share = np.linalg.norm(out, axis=1, keepdims=True)
    share = share / share.max()
    there = mesh.vertices + out
    tip = there[share[:, 0] > 0.5].mean(0)
    out += share * [0.0, RAISED, 0.0] + share * (FLAT - 1) * (there - tip) * [0.0, 1.0, 0.0]
    out += part_lips(tongue.action_names, deltas)
    return Part("tongue", mesh, materials, "jaw", tongue.action_names, deltas)


def _lashes(strips: BasePart, options: dict[str, Any]) -> Part:
    place = strips.mesh(**options)
    hairs = lash_hairs(place)
    deltas = np.stack([hairs.weights @ moved for moved in strips.actions.astype(float)])
    materials = np.full(len(hairs.mesh.polygons), Material.LASHES, np.int32)
    return Part("lashes", hairs.mesh, materials, "lids", strips.action_names, deltas)
