"""Views of a head with its eyeballs."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from caricli.render.place_eyeballs import place_eyeballs
from caricli.render.shade import Look
from caricli.render.sky import sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.views import render_views
from caricli.template.fine_mesh import FineMesh
from caricli.template.template import Template


def head_views(
    head: Template,
    views: Iterable[str],
    size: int,
    fine: FineMesh | None = None,
    look: Look = Look(),  # noqa: B008 (frozen)
) -> list[np.ndarray]:
    """Draw a head from several sides, with eyeballs where the annotation knows its lids.

    head: Template in the shape of the face. views: keys of VIEWS. size: pixels, width and height of a picture. fine:
    FineMesh in the same shape, to draw instead; what its vertices see of the sky is carried over from the coarse ones,
    because rays take most of the time. look: Look of what is drawn, but for its eyeballs.
    Returns a list of (size, size, 4) uint8.
    """
    eyeballs = place_eyeballs(head, head.annotation)
    if fine is None:
        return render_views(head, views, size, replace(look, eyeballs=eyeballs))
    seen = fine.weights @ sky_visibility(head.vertices, head.faces, smooth_normals(head.vertices, head.faces))
    return render_views(fine.mesh, views, size, replace(look, eyeballs=eyeballs, visibility=seen.astype(np.float32)))
