"""Points of a plane that go with a few moved ones."""

import numpy as np

_NEAREST = 1e-6
"""Squared distance, of the handles' spread: a point that lies on a handle goes where it goes."""


def move_by_handles(points: np.ndarray, handles: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Affine moving least squares (Schaefer et al. 2006), as Yu et al. 2016 deform sketches with.

    At every point the affine map that takes the handles to their targets best, a handle weighted by the inverse of its
    squared distance.

    points: (N, 2). handles, targets: (K, 2), K of 3 or more that do not lie on one line.
    Returns (N, 2).
    """
    away = points[:, None] - handles[None]
    spread = float(np.square(handles - handles.mean(0)).sum(1).mean())
    weights = 1 / ((away**2).sum(2) + _NEAREST * max(spread, 1e-12))
    total = weights.sum(1, keepdims=True)
    centre = weights @ handles / total
    goal = weights @ targets / total
    own = handles[None] - centre[:, None]
    other = targets[None] - goal[:, None]
    moments = np.einsum("nk,nki,nkj->nij", weights, own, own)
    # Handles on one line say nothing across it: there a point keeps its place.
    moments += 1e-6 * np.trace(moments, axis1=1, axis2=2)[:, None, None] * np.eye(2)
    mixed = np.einsum("nk,nki,nkj->nij", weights, own, other)
    return goal + ((points - centre)[:, None] @ np.linalg.solve(moments, mixed))[:, 0]
