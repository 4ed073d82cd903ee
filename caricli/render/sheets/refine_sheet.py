"""A face before and after it was refined."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.render.sheets.fit_sheet import fit_sheet
from caricli.structures import Face
from caricli.template.template import Template


def refine_sheet(
    faces: Sequence[Face],
    anchors: np.ndarray,
    heads: Sequence[Template],
    given: np.ndarray,
    image: np.ndarray | None,
    size: int,
) -> np.ndarray:
    """Pictures of both fits one above the other, as ``fit_sheet`` draws them.

    faces: the Face before and after, with the camera of the picture. anchors: (L,) vertex ids of the landmarks. heads:
    Template in the shape of each, with its parts. given: (L, 2) pixels, NaN where unknown. image: (H, W, 3) uint8, or
    None. size: pixels of one view.
    Returns (H, W, 3) uint8. Raises InputError when a face has no camera.
    """
    rows = []
    for face, head in zip(faces, heads, strict=True):
        marked = replace(face, landmarks=face.require_camera().project(face.vertices[anchors]))
        rows.append(fit_sheet(marked, head, given, image, size))
    return contact_sheet(rows, 1, ["before", "after"])
