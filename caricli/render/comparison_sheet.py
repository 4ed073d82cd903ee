"""A head and what a model makes of it, with the difference in colour."""

import numpy as np

from caricli.render.contact_sheet import contact_sheet
from caricli.render.head_views import head_views

NEAR, FAR = (170, 170, 170), (190, 0, 30)
_WORST = 0.02  # of the height: from here on as red as it gets


def comparison_sheet(given, found, faces, annotation, size=320):
    """Three rows of views: the given head, the found one, and the found one coloured by its distance, grey to red.

    given, found: (V, 3) metres. faces: (F, 3). annotation: with ``curves`` and ``regions``. size: pixels of a view.
    Returns (H, W, 3) uint8.
    """
    worst = _WORST * np.ptp(given[:, 1])
    share = np.clip(np.linalg.norm(found - given, axis=1, keepdims=True) / worst, 0, 1)
    colours = (1 - share) * np.array(NEAR) + share * np.array(FAR)
    views = ("front", "three-quarter", "profile")
    rows = [
        head_views(given, faces, annotation, views, size),
        head_views(found, faces, annotation, views, size),
        head_views(found, faces, annotation, views, size, vertex_colours=colours),
    ]
    labels = ["given", "encoded", f"distance, red from {1000 * worst:.1f} mm"]
    return contact_sheet([np.hstack(row) for row in rows], 1, labels)
