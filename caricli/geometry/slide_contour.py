"""Contour landmarks that stay on the outline of a turned head."""

import numpy as np

BACKWARD_MARGIN = 0.02


def slide_contour(vertices, rotation, template, landmarks, paths):
    """Where on its path every contour landmark lies on the posed head's outline.

    A landmark moves to the point of its path that lies furthest outwards in the picture: forwards freely, as on the far
    side of a turned head; backwards (under the chin of a lifted head) only where outwards means up or down, and only
    for a gain of more than ``BACKWARD_MARGIN`` of the head's height. On a frontal head it stays where it was marked.

    vertices: (V, 3) face frame. rotation: (3, 3) of the camera. template: (V, 3), for the outward directions.
    landmarks: (N,) vertex ids. paths: N arrays of vertex ids, back to front, each with its landmark.
    Returns (N,) vertex ids.
    """
    outwards = template[landmarks, :2] - template[landmarks, :2].mean(0)
    directions = np.hstack([outwards, np.zeros((len(landmarks), 1))]) @ rotation[:2].T
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    margin = BACKWARD_MARGIN * np.ptp(template[:, 1])
    slid = np.array(landmarks)
    for k, path in enumerate(paths):
        reach = vertices[path] @ rotation[:2].T @ directions[k]
        start = int(np.flatnonzero(path == landmarks[k])[0])
        behind = -np.inf if abs(outwards[k, 0]) > abs(outwards[k, 1]) else margin
        reach[:start] = reach[:start] - behind if np.isfinite(behind) else -np.inf
        slid[k] = path[np.argmax(reach)]
    return slid
