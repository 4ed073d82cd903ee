"""A tongue behind teeth that a picture shows long."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from caricli.structures import Material, Part

REACH = 0.01
"""Of the head's height: teeth so near to a point, seen from the front, stand before it."""

SPARE = 0.004
"""Of it: how far behind them the tongue stays."""


def behind_teeth(parts: Sequence[Part], height: float) -> tuple[Part, ...]:
    """Parts with the tongue drawn back behind the upper teeth, its tip the most and its root not at all.

    Teeth that grow down as far as a picture shows them come to where a tongue lies in a laugh. Others have room.

    parts: in one face of a height in metres, +z out of it; without tongue or upper teeth they stay as they are.
    """
    tongues = [k for k, part in enumerate(parts) if (part.materials == Material.TONGUE).any()]
    rows = [part for part in parts if part.hangs_on == "skull" and (part.materials == Material.TEETH).any()]
    if not tongues or not rows:
        return tuple(parts)
    moved = list(parts)
    teeth = np.concatenate([_teeth(row) for row in rows])
    for k in tongues:
        vertices = np.asarray(parts[k].mesh.vertices, float)
        depth = vertices[:, 2]
        share = (depth - depth.min()) / max(np.ptp(depth), 1e-9)
        near = KDTree(teeth[:, :2]).query_ball_point(vertices[:, :2], REACH * height)
        backs = np.array([teeth[ids, 2].min(initial=np.inf) for ids in near])
        beyond = np.maximum(depth - backs + SPARE * height, 0)
        back = float(np.max(beyond / np.maximum(share, 1e-9), initial=0.0))
        mesh = parts[k].mesh.with_vertices(vertices - np.outer(back * share, [0.0, 0.0, 1.0]))
        moved[k] = replace(parts[k], mesh=mesh)
    return tuple(moved)


def _teeth(part: Part) -> np.ndarray:
    """(N, 3) the vertices of what is teeth of a part, not gums."""
    ids = np.unique(part.mesh.polygons[part.materials == Material.TEETH])
    return np.asarray(part.mesh.vertices, float)[ids[ids >= 0]]
