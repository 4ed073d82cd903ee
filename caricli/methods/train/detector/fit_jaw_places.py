"""Where people mark the points of a jaw, learnt from meshes whose shape carries them."""

import numpy as np

from caricli.geometry.lines.space_jaw import carry_jaw, jaw_shares, space_jaw
from caricli.models.detector.jaw_places import JawPlaces, face_shape
from caricli.models.detector.usual_shapes import UsualShapes
from caricli.structures.landmarks import MIRRORED

RIDGE = 1.0
"""Weight of the squared numbers of the map: of 0.1, 1 and 10 the best on people who were left out."""

_AXES = 20
_CORE = 0.2  # of all faces, which are alike: of the generated ones a third is not exaggerated, or hardly
_ROUNDS = 10


def fit_jaw_places(faces: np.ndarray) -> JawPlaces:
    """Ridge regression from the shape of a face, its jaw marked evenly, to where the usual head's points are carried.

    Which faces are usual is found in the same.

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
    return JawPlaces(weight, usual - weight @ middle, usual_shapes(shapes))


def usual_shapes(shapes: np.ndarray) -> UsualShapes:
    """The UsualShapes of those of shapes (M, N) that are most alike.

    The nearest fifth of all is taken anew until it is the same (concentration steps; Rousseeuw and Van Driessen 1999).
    """
    core = np.ones(len(shapes), bool)
    for _ in range(_ROUNDS):
        usual = UsualShapes.of(shapes[core], _AXES)
        distances = usual.distances(shapes)
        nearest = distances <= np.quantile(distances, _CORE)
        if (nearest == core).all():
            break
        core = nearest
    return usual


def _with_mirrored(faces: list[np.ndarray]) -> np.ndarray:
    """(2 N, L, 2) landmarks of faces, and of their mirror images."""
    own = np.array(faces)
    return np.concatenate([own, own[:, list(MIRRORED)[: own.shape[1]]] * [-1, 1]])
