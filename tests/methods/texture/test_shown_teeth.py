import numpy as np
import pytest

from caricli.methods.parts.incisors import lip_middles
from caricli.methods.texture.shown_teeth import shown_teeth
from caricli.structures import Camera, Face
from caricli.structures.landmarks import LIP_PAIRS
from caricli.structures.parsing import Region

CAMERA = Camera(1000.0, np.diag([1.0, -1, -1]), np.array([150.0, 200.0]))
WAYS = {"jawOpen": 1.0, "mouthUpperUpLeft": 1.0, "mouthUpperUpRight": 1.0}


@pytest.fixture(scope="module")
def laughing(head, head_template):
    """A head with an open mouth."""
    moves = sum(weight * head.actions[head.action_names.index(name)] for name, weight in WAYS.items())
    return head_template.with_vertices(head_template.vertices + moves)


def shares(head, rows):
    """Shares of the open mouth's height that are told of a picture with such rows in it, None where nothing is told.

    rows: Region, and to which share of the way between the lips.
    """
    points = CAMERA.project(head.vertices[head.annotation.landmarks])
    middle = points[list(LIP_PAIRS[1])]
    regions = np.full((400, 300), Region.LIPS, np.uint8)
    start = 0.0
    for region, end in rows:
        first, last = (round(middle[0, 1] + share * (middle[1, 1] - middle[0, 1])) for share in (start, end))
        regions[first:last] = region
        start = end
    lengths = shown_teeth(Face(head, CAMERA, landmarks=points), head, regions)
    lips = head.vertices[lip_middles(head)]
    return None if lengths is None else lengths / np.linalg.norm(lips[0] - lips[1])


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ([(Region.TEETH, 1.0)], (1, 0)),
        ([(Region.MOUTH, 1.0)], (0, 0)),
        ([(Region.TEETH, 0.4), (Region.MOUTH, 1.0)], (0.4, 0)),
        ([(Region.MOUTH, 0.7), (Region.TEETH, 1.0)], (0, 0.3)),
        ([(Region.MOUTH, 0.1), (Region.TEETH, 0.9), (Region.MOUTH, 1.0)], (0.9, 0)),
        ([(Region.TEETH, 0.3), (Region.MOUTH, 0.8), (Region.TEETH, 1.0)], (0.3, 0.2)),
        ([(Region.TEETH, 0.5), (Region.MOUTH, 0.57), (Region.TEETH, 0.9), (Region.MOUTH, 1.0)], (0.9, 0)),
        ([(Region.TEETH, 0.15), (Region.LIPS, 0.22), (Region.TEETH, 1.0)], (1, 0)),
        ([(Region.TEETH, 0.3), (Region.MOUTH, 0.5), (Region.TEETH, 0.6), (Region.MOUTH, 1.0)], (0.3, 0)),
        ([(Region.TEETH, 0.3), (Region.MOUTH, 0.7), (Region.TEETH, 0.95), (Region.MOUTH, 1.0)], (0.3, 0.3)),
        ([(Region.MOUTH, 0.6), (Region.TEETH, 0.8), (Region.MOUTH, 1.0)], (0, 0)),
        ([(Region.LIPS, 1.0)], None),
    ],
)
def test_rows_of_teeth_are_told(laughing, rows, expected):
    told = shares(laughing, rows)
    if expected is None:
        assert told is None
    else:
        np.testing.assert_allclose(told, expected, atol=0.12)


def test_one_dark_row_of_pixels_makes_no_lower_teeth_of_upper_ones(laughing):
    """Between teeth that end in the middle of the mouth, wherever it is."""
    plain = shares(laughing, [(Region.TEETH, 0.6), (Region.MOUTH, 1.0)])
    for start in np.linspace(0.1, 0.5, 5):
        line = [(Region.TEETH, start), (Region.MOUTH, start + 0.02), (Region.TEETH, 0.6), (Region.MOUTH, 1.0)]
        np.testing.assert_allclose(shares(laughing, line), plain, atol=0.02)


def test_closed_lips_tell_nothing(head_template):
    assert shares(head_template, [(Region.TEETH, 1.0)]) is None
