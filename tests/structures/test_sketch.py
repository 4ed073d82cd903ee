import numpy as np
import pytest

from caricli.errors import InputError
from caricli.limits import MAX_SKETCH_POINTS, MAX_STROKES
from caricli.structures import Sketch, Stroke, StrokeKind

RING = np.array([[0.0, 0], [3, 0], [3, 4], [0, 0]])


def test_length_and_ends():
    assert Stroke(RING).length == 12 and Stroke(RING).closed
    assert not Stroke(RING[:3]).closed
    dot = Stroke(RING[:1])
    assert dot.length == 0 and not dot.closed


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"points": np.zeros((0, 2))}, "points: expected the shape"),
        ({"points": np.zeros((3, 3))}, "points: expected the shape"),
        ({"points": np.full((3, 2), np.nan)}, "points: expected finite"),
        ({"points": np.full((3, 2), 1e9)}, "points: expected finite"),
        ({"pressure": np.ones(3)}, "pressure: expected the shape"),
        ({"pressure": np.array([0, 0.5, 1, 1.1])}, "pressure: expected finite numbers of at most 1"),
        ({"pressure": np.array([0, 0.5, 1, -0.1])}, "pressure: .*negative"),
        ({"width": 0.0}, "width: expected more than 0"),
        ({"width": float("nan")}, "width: expected finite"),
        ({"curve": ""}, "curve: expected a name"),
        ({"curve": "a\nb"}, "curve: expected a name"),
    ],
    ids=str,
)
def test_what_is_no_stroke_is_refused(values, message):
    with pytest.raises(InputError, match=message):
        Stroke(**({"points": RING} | values))
    assert Stroke(RING, StrokeKind.WRINKLE, "nose", np.linspace(0, 1, 4), 0.5).width == 0.5


def test_too_much_is_refused():
    with pytest.raises(InputError, match="expected at most 20000"):
        Sketch((Stroke(RING),) * (MAX_STROKES + 1))
    long = Stroke(np.zeros((MAX_SKETCH_POINTS // 2 + 1, 2)))
    with pytest.raises(InputError, match="points together"):
        Sketch((long, long))
    with pytest.raises(InputError, match="a canvas of 1"):
        Sketch((), (0, 10))


def test_scaling_keeps_the_corners_of_the_canvas():
    # Corners lie half a pixel beside the centres of pixels.
    corners = np.array([[-0.5, -0.5], [99.5, 49.5]])
    scaled = Sketch((Stroke(corners, width=2.0),), (100, 50)).scaled((200, 200))
    assert np.allclose(scaled.strokes[0].points, [[-0.5, 49.5], [199.5, 149.5]])
    assert scaled.size == (200, 200) and scaled.strokes[0].width == 4
