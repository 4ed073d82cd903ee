"""Views of a head with its eyeballs."""

import numpy as np

from caricli.render.place_eyeballs import place_eyeballs
from caricli.render.sky import sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import render_views


def head_views(vertices, faces, annotation, views, size, fine=None, **looks):
    """Draw a head from several sides, with eyeballs where the annotation knows its lids.

    vertices: (V, 3), face frame. faces: (F, 3). annotation: with ``curves`` and ``regions``. views, size, looks: as in
    `render_views`. fine: (vertices (W, 3), faces, weights (W, V)) of a subdivision to draw instead; what its vertices
    see of the sky is carried over from the coarse ones, because rays take most of the time.
    Returns a list of (size, size, 4) uint8.
    """
    looks["eyeballs"] = place_eyeballs(vertices, faces, annotation.curves, annotation.regions)
    if fine is None:
        return render_views(vertices, faces, views, size, **looks)
    fine_vertices, fine_faces, weights = fine
    seen = weights @ sky_visibility(vertices, faces, smooth_normals(vertices, faces))
    return render_views(fine_vertices, fine_faces, views, size, visibility=seen.astype(np.float32), **looks)
