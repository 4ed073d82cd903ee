"""Whether heads stand as they have to: upright, with their left at +x, and their outside out."""

from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming
from caricli.geometry.alignment.require_upright import require_upright
from caricli.geometry.facing_out import facing_out
from caricli.structures.landmarks import COUNT, JAW
from caricli.template.head import load_head
from caricli.template.template import Template

BESIDE = 0.01
"""Of the head's height: how far from x = 0 the plane between the sides of a head may be that has a mirror map."""


def check_head(template: Template, mesh_folder: Path, annotation_path: Path) -> None:
    """Refuse a head that lies, looks aside, is mirrored or inside out, or has no mirror map of x = 0.

    template: in the mean shape of the meshes, metres. mesh_folder, annotation_path: which of them is at fault is named.
    Raises InputError.
    """
    usual = load_head().template()
    with naming(f"{mesh_folder}, by the landmarks of {annotation_path}"):
        require_upright(_landmarks(template), _landmarks(usual))
    with naming(mesh_folder):
        # Halfway between the ears is behind every face, of a mask, too.
        middle = _landmarks(template)[[JAW[0], JAW[-1]]].mean(0)
        if facing_out(template.vertices, template.faces, middle) < 0:
            raise InputError("expected faces that are counter-clockwise from outside, found the heads inside out")
    with naming(annotation_path):
        _check_mirror(template)


def _landmarks(template: Template) -> np.ndarray:
    """The 68 landmarks (68, 3) of a head, metres."""
    return template.vertices[template.annotation.landmarks[:COUNT]]


def _check_mirror(template: Template) -> None:
    """Raise InputError where the mirror map is not that of x = 0, from which mirror images are made."""
    mirror = template.annotation.mirror
    if mirror is not None:
        beside = float(np.median(template.vertices[:, 0] + template.vertices[mirror, 0])) / 2
        if abs(beside) > BESIDE * template.height:
            raise InputError(f"mirror: expected meshes whose sides meet at x = 0, found them to meet at {beside:.3g} m")
