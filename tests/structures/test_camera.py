import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from caricli.errors import InputError
from caricli.structures import Camera

POINTS = np.random.default_rng(0).normal(size=(7, 3))
TURN = Rotation.from_euler("xyz", [170, 20, -30], degrees=True).as_matrix()


def some():
    return Camera(250.0, TURN, np.array([30.0, -4.0]))


def test_project_is_the_formula():
    pixels = some().project(POINTS)
    expected = [250 * np.array([TURN[0] @ p, TURN[1] @ p]) + [30, -4] for p in POINTS]
    np.testing.assert_allclose(pixels, expected)
    np.testing.assert_allclose(some().project(POINTS[None])[0], pixels)
    np.testing.assert_allclose(some().project(POINTS[2]), pixels[2])


def test_place_adds_the_depth_in_pixels():
    placed = some().place(POINTS)
    np.testing.assert_allclose(placed[:, :2], some().project(POINTS))
    np.testing.assert_allclose(placed[:, 2], 250 * POINTS @ TURN[2])
    lengths = np.linalg.norm(np.diff(placed, axis=0), axis=1)
    np.testing.assert_allclose(lengths, 250 * np.linalg.norm(np.diff(POINTS, axis=0), axis=1))


def test_lift_meets_the_pixels_and_keeps_the_depth():
    pixels = np.random.default_rng(1).uniform(0, 500, (7, 2))
    lifted = some().lift(pixels, POINTS)
    np.testing.assert_allclose(some().project(lifted), pixels)
    np.testing.assert_allclose(some().place(lifted)[:, 2], some().place(POINTS)[:, 2])
    np.testing.assert_allclose(some().lift(some().project(POINTS), POINTS), POINTS)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(zoom=st.floats(0.01, 100), x=st.floats(-1e3, 1e3), y=st.floats(-1e3, 1e3))
def test_zoomed_sees_the_cut_out_picture(zoom, x, y):
    corner = np.array([x, y])
    zoomed = some().zoomed(zoom, corner)
    np.testing.assert_allclose(
        zoomed.project(POINTS), (some().project(POINTS) - corner + 0.5) * zoom - 0.5, rtol=1e-9, atol=1e-6
    )
    np.testing.assert_array_equal(zoomed.rotation, some().rotation)


def test_zoomed_by_default_keeps_the_border_of_the_picture():
    np.testing.assert_allclose(some().zoomed(2).project(POINTS) + 0.5, 2 * (some().project(POINTS) + 0.5))


def test_what_a_camera_holds():
    camera = Camera(np.float32(2), TURN.tolist(), [1, 2])
    assert type(camera.scale) is float and camera.rotation.dtype == camera.translation.dtype == np.float64
    with pytest.raises(AttributeError):
        camera.scale = 3.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"scale": 0.0}, "camera_scale: expected from 1e-06 to 1e[+]06 pixels per metre, found 0"),
        ({"scale": -1.0}, "camera_scale: expected from 1e-06"),
        ({"scale": np.nan}, "camera_scale: expected finite numbers"),
        ({"scale": np.inf}, "camera_scale: expected finite numbers"),
        ({"scale": np.ones(1)}, r"camera_scale: expected the shape \(\), found \(1,\)"),
        ({"rotation": np.eye(2)}, r"camera_rotation: expected the shape \(3,3\), found \(2, 2\)"),
        ({"rotation": np.eye(3) * np.nan}, "camera_rotation: expected finite numbers"),
        ({"rotation": -np.eye(3)}, "camera_rotation: expected a proper rotation, found another matrix"),
        ({"rotation": np.diag([1.0, 1, -1])}, "camera_rotation: expected a proper rotation"),
        ({"rotation": 2 * np.eye(3)}, "camera_rotation: expected a proper rotation"),
        ({"rotation": 1e200 * np.eye(3)}, "camera_rotation: expected"),
        ({"rotation": TURN + 1e-3}, "camera_rotation: expected a proper rotation"),
        ({"rotation": np.zeros((3, 3))}, "camera_rotation: expected a proper rotation"),
        ({"translation": np.zeros(3)}, r"camera_translation: expected the shape \(2\), found \(3,\)"),
        ({"translation": [0, np.inf]}, "camera_translation: expected finite numbers"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_what_is_no_camera_is_refused(changes, words):
    parts = {"scale": 1.0, "rotation": TURN, "translation": np.zeros(2)} | changes
    with pytest.raises(InputError, match=words):
        Camera(**parts)


def test_a_rotation_in_single_precision_is_one():
    np.testing.assert_allclose(Camera(1, TURN.astype(np.float32), [0, 0]).rotation, TURN, atol=1e-6)
