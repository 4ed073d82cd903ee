"""Upper lids of open eyes: folded skin of which a picture shows lines and shadows, and a blink much more."""

from functools import cache

import numpy as np

from caricli.geometry.eye_openness import eye_openness
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.rig.head_expressions import BLINKS, open_head_expressions
from caricli.methods.texture.fill_unseen import vertex_areas
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT
from caricli.template.template import Template

_MOVED = (0.05, 0.25)  # of what a blink moves at most, from where on and with which skin is of a lid that comes down
_STRETCHED = (1.1, 1.7)  # times as large in a blink, from where on and with which skin comes out of a fold
_OPEN = 0.5  # of how open an eye usually is, from which on its lid is folded
_SOCKETS = ("eye_socket_left", "eye_socket_right")
_EDGES = ("eye_upper_left", "eye_upper_right")


def folded_lids(head: Template) -> np.ndarray:
    """(V,) from 0 to 1, how far vertices are of an upper lid that is folded; its edge is not, where lashes are drawn.

    head: Template in the shape of a face; of a topology other than the open head's nothing is known, and none is.
    """
    actions = open_head_expressions()
    if head.topology_id != actions.mesh.topology_id:
        return np.zeros(len(head.vertices))
    marks, usual = (vertices[head.annotation.landmarks] for vertices in (head.vertices, actions.neutral))
    folded = np.zeros(len(head.vertices))
    for eye, lid in zip((EYE_LEFT, EYE_RIGHT), _lids(), strict=True):
        openness = eye_openness(marks[list(eye)]) / eye_openness(usual[list(eye)])
        folded = np.maximum(folded, min(openness / _OPEN, 1.0) * lid)
    return folded


@cache
def _lids() -> list[np.ndarray]:
    """The open head's lids, left and right, (V,) from 0 to 1."""
    actions = open_head_expressions()
    assert actions.annotation is not None
    adjacency, _ = vertex_neighbours(actions.faces, len(actions.neutral))
    socket = np.zeros(len(actions.neutral), bool)
    socket[np.concatenate([actions.annotation.regions[name] for name in _SOCKETS])] = True
    edge = socket | (adjacency @ socket > 0)
    edge[np.concatenate([actions.annotation.curves[name] for name in _EDGES])] = True
    before = vertex_areas(actions.mesh)
    lids = []
    for name in BLINKS:
        moves = actions.deltas[actions.names.index(name)]
        moved = np.interp(-moves[:, 1] / np.abs(moves[:, 1]).max(), _MOVED, (0, 1))
        after = vertex_areas(actions.mesh.with_vertices(actions.neutral + moves))
        stretched = np.interp(after / before, _STRETCHED, (0, 1))
        lids.append(np.where(edge, 0, np.maximum(moved, stretched)))
    return lids
