"""Points of the jaw, at equal distances along it."""

import numpy as np

from caricli.structures.landmarks import JAW, POINT_NAMES

_LEAST = 1e-6
"""Distance that two neighbours have at least, of the jaw's length."""


def space_jaw(points: np.ndarray) -> np.ndarray:
    """Landmarks (L, 2) whose jaw's points stand at equal distances along it, on either side from the ear to the chin.

    So they are marked by hand (iBUG; Sagonas et al. 2013), because the jaw has nothing else to know them by. On meshes
    they are vertices, which lie nearer to the chin. Ears and chin stay where they are.
    """
    from scipy.interpolate import PchipInterpolator

    points = points.copy()
    chin = POINT_NAMES["chin"]
    for side in (slice(JAW.start, chin + 1), slice(chin, JAW.stop)):
        own = points[side]
        steps = np.linalg.norm(np.diff(own, axis=0), axis=1)
        steps = np.maximum(steps, max(_LEAST * steps.sum(), np.finfo(float).tiny))
        along = np.concatenate([[0], np.cumsum(steps)])
        points[side] = PchipInterpolator(along, own)(np.linspace(0, along[-1], len(own)))
    return points
