import numpy as np
import pytest

from caricli.geometry.uvs_beyond import uvs_beyond


@pytest.mark.parametrize(
    ("least", "most", "words"),
    [(0, 1, None), (-1e-4, 1.0001, None), (0, 2, "from 0 to 2"), (-0.25, 1, "from -0.25 to 1")],
)
def test_uvs_beyond_their_picture_are_told(least, most, words):
    assert uvs_beyond(np.array([[0.5, least], [most, 0.5]])) == words
