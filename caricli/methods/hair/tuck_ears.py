"""Ears under hair, of which only a part shows."""

import numpy as np

from caricli.geometry.repair.untangle import untangle
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.hair.hair_view import HairView
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.hidden_hairline import MOSTLY, far_ear
from caricli.methods.hair.settings import ShellSettings
from caricli.template.annotation import EARS
from caricli.template.template import Template

_ROUNDS = 4  # of bringing to neighbours what is hidden of an ear, so that it bends


def tuck_ears(sphere: HeadSphere, view: HairView, settings: ShellSettings) -> Template:
    """The head of a sphere with what hair hides of its ears laid against it, where a part of them shows.

    Hair ends before that part, and what is hidden beside it would stick out of the hair. So would an ear on the far
    side that is under hair as the other one.

    sphere: HeadSphere of the head. view: HairView of the head.
    """
    head = sphere.head
    hidden = np.zeros(len(head.vertices))
    far = far_ear(sphere, view)
    for number, name in enumerate(EARS):
        ids = head.annotation.regions[name]
        bare = view.bare(head.vertices[ids])
        if number == far:
            hidden[ids] = 1
        elif 0 < bare.mean() <= MOSTLY:
            hidden[ids] = ~bare
    if not hidden.any():
        return head
    _, mean = vertex_neighbours(head.faces, len(head.vertices))
    ears = head.mask(*EARS)
    for _ in range(_ROUNDS):
        hidden = np.where(ears, mean @ hidden, 0)
    longitudes, angles, radii = sphere.seen_from(head.vertices)
    above = np.maximum(radii - sphere.ground(longitudes, angles) - settings.least * head.height, 0)
    share = 1 - hidden * above / np.maximum(radii, np.finfo(float).tiny)
    tucked = sphere.middle + share[:, None] * (head.vertices - sphere.middle)
    smooth = untangle(tucked, head.gradients, before=head.vertices)
    return head.with_vertices(np.where(ears[:, None], smooth, head.vertices))
