import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import InputError
from caricli.io.takes.mediapipe_head import mediapipe_head
from caricli.methods.animate.turn_head import turn_head

ANGLES = np.array([[0.4, -0.2, 0.1], [3.0, 0.3, -0.2], [3.3, 0.2, 0.0]])


def pose(angles, size=1.02):
    """MediaPipe's matrix (4, 4) of a head half a metre before the camera, in centimetres."""
    matrix = np.eye(4)
    matrix[:3, :3] = size * Rotation.from_euler("YXZ", angles).as_matrix()
    matrix[:3, 3] = [3.0, -2.0, -50.0]
    return matrix


@pytest.mark.parametrize(
    "result",
    [
        lambda matrix: {"facial_transformation_matrixes": [matrix.tolist()]},
        lambda matrix: {"facialTransformationMatrixes": [{"rows": 4, "columns": 4, "data": matrix.T.ravel().tolist()}]},
        lambda matrix: {"facial_transformation_matrixes": [matrix.ravel().tolist(), np.eye(4).tolist()]},
    ],
)
def test_the_head_turns_as_the_matrix_does(result):
    head = mediapipe_head([result(pose(angles)) for angles in ANGLES], [0, 1, 2])
    np.testing.assert_allclose(head, ANGLES, atol=1e-9)
    turns = Rotation.from_quat(turn_head(head)).as_matrix()
    np.testing.assert_allclose(turns, [pose(angles, 1)[:3, :3] for angles in ANGLES], atol=1e-9)


def test_a_face_that_turns_to_its_left_shows_that_side_less():
    """+x of the canonical face goes away from the camera, which looks along -z."""
    head = mediapipe_head([{"facial_transformation_matrixes": [pose([0.5, 0, 0]).tolist()]}], [0])
    assert head[0, 0] == pytest.approx(0.5)
    assert (Rotation.from_quat(turn_head(head)[0]).apply([1, 0, 0]))[2] < 0


def test_without_matrices_the_head_keeps_still():
    for results in ([{"face_blendshapes": []}], [[{"score": 1}]], [{"facial_transformation_matrixes": []}]):
        assert mediapipe_head(results, [0]) is None


@pytest.mark.parametrize(
    ("matrix", "said"),
    [
        ([[1, 2], [3, 4]], "expected a matrix of 4 x 4 numbers"),
        ("pose", "expected a matrix of 4 x 4 numbers"),
        (np.full((4, 4), np.nan).tolist(), "expected a matrix of 4 x 4 numbers"),
        ([[1, 0, 0, 0], [0, 1, 0, 0], [1e308, 0, 1, 0], [0, 0, 0, 1]], "expected a matrix of 4 x 4 numbers"),
        ([[1, 0, 0, 0], [0, 1, 0, 0], [1e30, 0, 1, 0], [0, 0, 0, 1]], "expected a matrix of 4 x 4 numbers"),
        (np.ones((4, 4)).tolist(), "expected the matrix of a pose"),
        (np.diag([1.0, 1, -1, 1]).tolist(), "expected the matrix of a pose"),
        (np.diag([0.0, 0, 0, 1]).tolist(), "expected the matrix of a pose"),
    ],
)
def test_what_is_no_pose_says_the_frame(matrix, said):
    good = {"facial_transformation_matrixes": [pose([0, 0, 0]).tolist()]}
    with pytest.raises(InputError, match=f"frame 7: {said}"):
        mediapipe_head([good, {"facial_transformation_matrixes": [matrix]}], [5, 7])
    with pytest.raises(InputError, match="frame 7: expected facial_transformation_matrixes as in other frames"):
        mediapipe_head([good, {}], [5, 7])
