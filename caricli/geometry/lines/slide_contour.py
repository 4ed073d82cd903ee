"""Contour landmarks that stay on the outline of a turned head."""

from collections.abc import Sequence

import numpy as np

BACKWARD_MARGIN = 0.02
"""Of the head's height: the near side stays where it was marked unless it gains more."""

FORWARD_MARGIN = 0.001
"""Of the head's height: rounding alone moves nothing."""


def slide_contour(
    vertices: np.ndarray,
    rotation: np.ndarray,
    template: np.ndarray,
    landmarks: np.ndarray,
    paths: Sequence[np.ndarray],
) -> np.ndarray:
    """Where on its path every contour landmark lies on the posed head's outline.

    A landmark moves to the point of its path that lies furthest outwards in the picture: forwards, as on the far side
    of a turned head, for a gain of more than ``FORWARD_MARGIN`` of the head's height; backwards (under the chin of a
    lifted head) only where outwards means up or down, and only for a gain in that direction of more than
    ``BACKWARD_MARGIN``. On a frontal head it stays where it was marked.

    vertices: (V, 3) face frame. rotation: (3, 3) of the camera. template: (V, 3), for the outward directions.
    landmarks: (N,) vertex ids. paths: N arrays of vertex ids, back to front, each with its landmark.
    Returns (N,) vertex ids.
    """
    outwards = template[landmarks, :2] - template[landmarks, :2].mean(0)
    directions = np.hstack([outwards, np.zeros((len(landmarks), 1))]) @ rotation[:2].T
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    height = np.ptp(template[:, 1])
    slid = np.array(landmarks)
    for k, path in enumerate(paths):
        start = int(np.flatnonzero(path == landmarks[k])[0])
        seen = (vertices[path] - vertices[landmarks[k]]) @ rotation[:2].T
        gain = seen @ directions[k] - FORWARD_MARGIN * height
        gain[start] = 0.0
        if abs(outwards[k, 0]) > abs(outwards[k, 1]):
            gain[:start] = -np.inf
        else:
            # A turn alone must not pull the near side under the jaw, so sideways gains do not count.
            gain[:start] = seen[:start] @ rotation[:2, 1] * np.sign(outwards[k, 1]) - BACKWARD_MARGIN * height
        slid[k] = path[np.argmax(gain)]
    return slid
