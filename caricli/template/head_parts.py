"""Teeth, tongue and lashes of the open head."""

from typing import Any

import numpy as np

from caricli.geometry.similarity import similarity
from caricli.structures import Material
from caricli.structures.parts import Hold, Part
from caricli.template.dental_arch import STYLES, dental_arch
from caricli.template.head import BasePart, Head
from caricli.template.lash_hairs import lash_hairs

_STILL = 1e-6
"""Metres: what an action moves less it does not move."""


def head_parts(head: Head, style: str = "natural", **options: Any) -> tuple[Part, ...]:
    """The parts of ``head.evaluate(**options)``, moved by the 52 ARKit actions.

    Teeth are modelled on the bands of the base mesh and move as rigidly as bone; lashes are single hairs along its
    strips; the tongue is the base mesh's own.

    style: a key of ``dental_arch.STYLES``.
    """
    teeth = [_teeth(head.parts[f"teeth_{row}"], row, style, options) for row in ("upper", "lower")]
    return (*teeth, _tongue(head.parts["tongue"], options), _lashes(head.parts["lashes"], options))


def _teeth(band: BasePart, row: str, style: str, options: dict[str, Any]) -> Part:
    place = band.mesh(**options)
    mesh, materials = dental_arch(place, row == "upper", STYLES[style])
    deltas = np.zeros((len(band.action_names), *mesh.vertices.shape))
    for k, moved in enumerate(band.actions.astype(float)):
        if np.abs(moved).max() > _STILL:
            _, rotation, translation = similarity(place.vertices, place.vertices + moved, scaling=False)
            deltas[k] = mesh.vertices @ rotation.T + translation - mesh.vertices
    hold: Hold = "skull" if row == "upper" else "jaw"
    return Part(f"teeth_{row}", mesh, materials, hold, band.action_names, deltas)


def _tongue(tongue: BasePart, options: dict[str, Any]) -> Part:
    mesh = tongue.mesh(**options)
    materials = np.full(len(mesh.polygons), Material.TONGUE, np.int32)
    return Part("tongue", mesh, materials, "jaw", tongue.action_names, tongue.actions.astype(float))


def _lashes(strips: BasePart, options: dict[str, Any]) -> Part:
    place = strips.mesh(**options)
    hairs = lash_hairs(place)
    deltas = np.stack([hairs.weights @ moved for moved in strips.actions.astype(float)])
    materials = np.full(len(hairs.mesh.polygons), Material.LASHES, np.int32)
    return Part("lashes", hairs.mesh, materials, "lids", strips.action_names, deltas)
