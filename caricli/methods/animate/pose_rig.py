"""The run-time of a rig: one frame from its weights (portrait paper, equation 13)."""

import numpy as np
from scipy.linalg.blas import sgemv

from caricli.structures import Rig


class RigPoser:
    """Evaluates ``neutral + sum_k weight_k deltas_k`` in single precision, frame after frame, in one buffer.

    Neighbouring shapes that are not zero go through memory in one matrix-vector product; the others are not read.
    """

    def __init__(self, rig: Rig) -> None:
        """The deltas of the rig are not copied where they are float32 already."""
        self._neutral = np.ascontiguousarray(rig.neutral, np.float32).ravel()
        self._deltas = np.ascontiguousarray(rig.deltas, np.float32).reshape(len(rig.names), -1)
        self._weights = np.zeros(len(rig.names), np.float32)
        self._frame = self._neutral.copy()
        self._vertices = self._frame.reshape(-1, 3)
        self._vertices.flags.writeable = False

    def pose(self, weights: np.ndarray) -> np.ndarray:
        """Vertices (V, 3) float32 of weights (K,): a view that the next call overwrites; copy it to keep it."""
        self._weights[:] = weights
        self._frame[:] = self._neutral
        active = np.flatnonzero(self._weights)
        start = 0
        for end in range(1, len(active) + 1):
            if end == len(active) or active[end] != active[end - 1] + 1:
                run = slice(active[start], active[end - 1] + 1)
                sgemv(1, self._deltas[run].T, self._weights[run], beta=1, y=self._frame, overwrite_y=True)
                start = end
        return self._vertices
