"""A head and what a model makes of it, with the difference in colour."""

import numpy as np

from caricli.render.backdrop import row_of
from caricli.render.coat import Coat
from caricli.render.head_views import head_views
from caricli.render.shade import Look
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.template.template import Template

NEAR = (170, 170, 170)
FAR = (190, 0, 30)
_WORST = 0.02  # of the height: from here on as red as it gets


def comparison_sheet(
    given: Template,
    other: Template,
    size: int = 320,
    coat: Coat | None = None,
) -> np.ndarray:
    """Three rows of views: the given head, another shape of it, and this one coloured by its distance, grey to red.

    given, other: Template in the shapes of both, with their parts, which the last row leaves out. size: pixels of a
    view. coat: Coat of the given head, or None.
    Returns (H, W, 3) uint8.
    """
    worst = _WORST * np.ptp(given.vertices[:, 1])
    share = np.clip(np.linalg.norm(other.vertices - given.vertices, axis=1, keepdims=True) / worst, 0, 1)
    colours = (1 - share) * np.array(NEAR) + share * np.array(FAR)
    views = ("front", "three-quarter", "profile")
    rows = [
        head_views(given, views, size, look=Look(coat=coat)),
        head_views(other, views, size),
        head_views(other.with_vertices(other.vertices), views, size, look=Look(vertex_colours=colours)),
    ]
    labels = ["given", "encoded", f"distance, red from {1000 * worst:.1f} mm"]
    return contact_sheet([row_of(row) for row in rows], 1, labels)
