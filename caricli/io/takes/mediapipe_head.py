"""How the head turns in results of MediaPipe's Face Landmarker."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from caricli.errors import InputError, naming, shown
from caricli.structures.checks import number_problem

KEYS = ("facial_transformation_matrixes", "facialTransformationMatrixes")
_ROUND = 1e-3
"""How far the last row of a matrix may be from 0, 0, 0, 1."""


def mediapipe_head(results: Sequence[Any], frames: Sequence[int]) -> np.ndarray | None:
    """Yaw, pitch and roll (T, 3) in radians, as a Track has them, or None where no result has a matrix.

    A matrix moves MediaPipe's canonical face, whose axes are the face frame's (+x the face's left, +y up, +z out of
    it), to where the camera sees it; its place and size are not read. It is nested rows, or ``data`` of 16 numbers
    column by column as JavaScript gives them; where the 0, 0, 0, 1 stands tells rows from columns.

    frames: (T,) numbers of the results, for messages. Raises InputError when only some have one, or one is no pose.
    """
    matrices = [_matrix_of(result) for result in results]
    bare = [frame for frame, matrix in zip(frames, matrices, strict=True) if matrix is None]
    if len(bare) == len(frames):
        return None
    if bare:
        raise InputError(f"frame {bare[0]}: expected {KEYS[0]} as in other frames, found none")
    turns = []
    for frame, matrix in zip(frames, matrices, strict=True):
        with naming(f"frame {frame}"):
            turns.append(_rotation(matrix))
    return np.unwrap(Rotation.from_matrix(np.array(turns)).as_euler("YXZ"), axis=0)


def _matrix_of(result: Any) -> Any:
    """The matrix of the first face as the file has it, or None."""
    matrices = next((result[key] for key in KEYS if key in result), None) if isinstance(result, dict) else None
    matrix = matrices[0] if isinstance(matrices, list) and matrices else None
    return matrix["data"] if isinstance(matrix, dict) and "data" in matrix else matrix


def _rotation(value: Any) -> np.ndarray:
    """(3, 3) nearest to the linear part."""
    try:
        matrix = np.array(value, float)
    except (TypeError, ValueError):
        matrix = np.zeros(0)
    if matrix.shape not in ((4, 4), (16,)) or number_problem("matrix", matrix):
        raise InputError(f"expected a matrix of 4 x 4 numbers, found {shown(value, 60)}")
    # Without a place both readings fit: then a list is JavaScript's.
    matrix = matrix.reshape(4, 4).T if matrix.ndim == 1 else matrix
    last = np.array([0, 0, 0, 1])
    if np.abs(matrix[3] - last).max() > _ROUND:
        matrix = matrix.T
    linear = matrix[:3, :3]
    if np.abs(matrix[3] - last).max() > _ROUND or np.linalg.det(linear) <= _ROUND:
        raise InputError(f"expected the matrix of a pose, found {shown(value, 60)}")
    left, _, right = np.linalg.svd(linear)
    turn = left @ right
    if np.linalg.det(turn) < 0:  # of numbers so far apart that the sign of their determinant is rounding
        raise InputError(f"expected the matrix of a pose, found {shown(value, 60)}")
    return turn
