"""How large a face is in its picture."""

import numpy as np

from caricli.structures import Face
from caricli.structures.landmarks import COUNT

_LEAST = 8.0  # pixels: with fewer no shares of it are told apart


def face_size(face: Face) -> float:
    """Pixels, the longer side of the box around the first 68 landmarks, which every layout has; at least 8.

    face: Face with landmarks. Raises InputError for one without.
    """
    return max(float(np.ptp(face.require_landmarks()[:COUNT], axis=0).max()), _LEAST)
