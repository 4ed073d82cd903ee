"""Views of a head with its eyeballs."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from caricli.geometry.join_meshes import join_meshes
from caricli.render.face_look import head_eyeballs, with_parts
from caricli.render.shade import Look
from caricli.render.sky import mesh_sky
from caricli.render.views import render_views
from caricli.template.fine_mesh import FineMesh
from caricli.template.template import Template, WholeHead


def head_views(
    head: Template,
    views: Iterable[str],
    size: int,
    fine: FineMesh | None = None,
    look: Look = Look(),  # noqa: B008 (frozen)
) -> list[np.ndarray]:
    """Draw a head with its parts from several sides, with eyeballs where the annotation knows its lids.

    head: Template in the shape of the face, a WholeHead where it has parts. views: keys of VIEWS. size: pixels, width
    and height of a picture. fine: FineMesh in the same shape, to draw instead; what its vertices see of the sky is
    carried over from the coarse ones, because rays take most of the time. look: Look of the face, but for its eyeballs;
    its visibility is what `head_sky` gives, or None.
    Returns a list of (size, size, 4) uint8.
    """
    parts = head.dressed if isinstance(head, WholeHead) else ()
    drawn, look = with_parts(head if fine is None else fine.mesh, look, parts)
    seen = head_sky(head) if look.visibility is None else look.visibility
    if fine is not None:
        count = len(head.vertices)
        seen = np.concatenate([fine.weights @ seen[:count], seen[count:]])
    return render_views(
        drawn, views, size, replace(look, eyeballs=head_eyeballs(head), visibility=seen.astype(np.float32))
    )


def head_sky(head: Template) -> np.ndarray:
    """What the vertices of a head and its parts see of the sky, see ``sky_visibility``, for its pictures to share."""
    parts = head.dressed if isinstance(head, WholeHead) else ()
    whole = join_meshes([head, *(part.mesh for part in parts)]) if parts else head
    return mesh_sky(whole.vertices, whole.faces)
