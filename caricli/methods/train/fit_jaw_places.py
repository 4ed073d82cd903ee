"""Where people mark the points of a jaw, learnt from meshes whose shape carries them."""

import numpy as np

from caricli.geometry.space_jaw import carry_jaw, jaw_shares, space_jaw
from caricli.models.detector.jaw_places import JawPlaces, face_shape
from caricli.structures.landmarks import MIRRORED

RIDGE = 1.0
"""Weight of the squared numbers of the map: of 0.1, 1 and 10 the best on people who were left out."""


def fit_jaw_places(faces: np.ndarray) -> JawPlaces:
    """Ridge regression from the shape of a face, its jaw marked evenly, to where the usual head's points are carried.

    faces: (N, L, 2) true landmarks of meshes, seen by any camera; each counts with its mirror image.
    """
    spaced = _with_mirrored([space_jaw(face) for face in faces])
    carried = _with_mirrored([carry_jaw(face) for face in faces])
    shapes = np.array([face_shape(face) for face in spaced])
    shares = np.array([jaw_shares(face)[:, 1:-1].ravel() for face in carried])
    middle = shapes.mean(0)
    usual = shares.mean(0)
    apart = shapes - middle
    normal = apart.T @ apart + RIDGE * np.eye(len(middle))
    weight = np.linalg.solve(normal, apart.T @ (shares - usual)).T
    return JawPlaces(weight, usual - weight @ middle)


def _with_mirrored(faces: list[np.ndarray]) -> np.ndarray:
    """(2 N, L, 2) landmarks of faces, and of their mirror images."""
    own = np.array(faces)
    return np.concatenate([own, own[:, list(MIRRORED)[: own.shape[1]]] * [-1, 1]])
