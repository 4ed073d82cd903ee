import numpy as np
import pytest

from caricli.methods.sketch.page_frames import page_frames

TURN = np.linspace(0, 2 * np.pi, 60)
CIRCLE = np.column_stack([np.cos(TURN), np.sin(TURN)])
FACE = 128 + CIRCLE * [70, 90]
FEATURES = [[x, y] + 10 * CIRCLE for x, y in ((100, 100), (156, 100), (128, 130), (128, 170))]
SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])


@pytest.mark.parametrize("wobble", [0, 1.5])
def test_frames_around_a_face(wobble):
    page, panel = 2 + 250 * SQUARE, 12 + 230 * SQUARE
    drawn = np.concatenate([np.linspace(a, b, 20) for a, b in zip(panel[:-1], panel[1:], strict=True)])
    drawn += np.random.default_rng(0).uniform(-wobble, wobble, drawn.shape)
    assert page_frames([*FEATURES, page, FACE, drawn]) == [4, 6]
    mark = [[230.0, 235], [238, 238]]
    assert page_frames([FACE, page, *FEATURES, np.array(mark)]) == [1]


def test_what_is_no_frame():
    """A square face, a face, an open corner, a frame around nothing, or beside the face, and a window in it."""
    square = 40 + 180 * SQUARE
    assert page_frames([square, *FEATURES]) == []
    assert page_frames([FACE, *FEATURES]) == []
    assert page_frames([(2 + 250 * SQUARE)[:3], FACE, *FEATURES]) == []
    assert page_frames([square]) == page_frames([]) == []
    assert page_frames([[300, 0] + square, FACE, *FEATURES]) == []
    assert page_frames([FACE, *FEATURES, 120 + 20 * SQUARE]) == []
    assert page_frames([FACE[:1], 250 * SQUARE]) == []
