"""Eyeballs for heads that come without."""

from collections.abc import Sequence

import numpy as np

from caricli.structures import Mesh
from caricli.template.annotation import Annotation

_CLEARANCE = 1.02  # of the radius: how far the lids stay off the eyeball


def place_eyeballs(mesh: Mesh, annotation: Annotation) -> list[tuple[np.ndarray, float]]:
    """Put a ball into each eye socket: the sphere nearest to its surface, behind the middle of the lids' opening.

    mesh: Mesh. annotation: Annotation; used are the lid margins `eye_upper_*` and `eye_lower_*`, polylines along edges,
    and the regions `eye_socket_*`, for left and right; where there are regions `eyeball_*`, the mesh has eyes already.
    Returns a list of (centre (3,), radius), in the unit of the vertices; without the eyes that the annotation does not
    know, and empty where it does not fit the faces because it was made for another mesh.
    """
    return [ball for side in ("left", "right") if (ball := place_eyeball(mesh, annotation, side)) is not None]


def place_eyeball(mesh: Mesh, annotation: Annotation, side: str) -> tuple[np.ndarray, float] | None:
    """The one of ``place_eyeballs`` on a side, "left" or "right", or None."""
    curves = annotation.curves
    lids = [np.asarray(curves[name]) for name in (f"eye_upper_{side}", f"eye_lower_{side}") if name in curves]
    socket = np.asarray(annotation.regions.get(f"eye_socket_{side}", ()), int)
    own = f"eyeball_{side}" in annotation.regions
    if own or len(lids) < 2 or len(socket) < 4 or not _fits(mesh, lids, socket):
        return None
    vertices = np.asarray(mesh.vertices, float)
    return _ball(vertices[socket], vertices[np.concatenate(lids)])


def _ball(lining: np.ndarray, margin: np.ndarray) -> tuple[np.ndarray, float]:
    middle = lining.mean(0)
    # |p - c|^2 = r^2 is linear in c and |c|^2 - r^2.
    p = lining - middle
    c = np.linalg.lstsq(np.column_stack([2 * p, np.ones(len(p))]), (p**2).sum(1), rcond=None)[0]
    centre = middle + c[:3]
    radius = np.sqrt(max(c[3] + (c[:3] ** 2).sum(), 0))
    # Half way to the middle of the opening: exaggerated lids leave their socket, and the eyes would squint.
    centre[:2] = (centre[:2] + (margin.min(0) + margin.max(0))[:2] / 2) / 2
    # As far forward as every point of the margins allows.
    aside = ((margin - centre)[:, :2] ** 2).sum(1)
    centre[2] = min(centre[2], (margin[:, 2] - np.sqrt(np.maximum((_CLEARANCE * radius) ** 2 - aside, 0))).min())
    return centre, float(radius)


def _fits(mesh: Mesh, lids: Sequence[np.ndarray], socket: np.ndarray) -> bool:
    """Whether the ids exist and neighbours along the lids share an edge of the mesh."""
    if max(socket.max(), *(lid.max() for lid in lids)) >= len(mesh.vertices):
        return False
    on_lids = np.zeros(len(mesh.vertices), bool)
    on_lids[np.concatenate(lids)] = True
    near = mesh.faces[on_lids[mesh.faces].any(1)]
    edges = _numbered(near[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2))
    return all(np.isin(_numbered(np.stack([lid[:-1], lid[1:]], 1)), edges).all() for lid in lids)


def _numbered(edges: np.ndarray) -> np.ndarray:
    """One number for each edge (E, 2), whatever its direction."""
    low, high = np.sort(edges.astype(np.int64), axis=1).T
    return low << 32 | high
