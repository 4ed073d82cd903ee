import cv2
import numpy as np
import pytest

from caricli.methods.dynamic.chart_pictures import ChartGrid, texture_to_chart
from caricli.methods.dynamic.retouch_texture import retouch_texture
from caricli.structures import Face, Pictures
from caricli.template.chart import face_chart

SIZE = 128


@pytest.fixture(scope="module")
def chart(head_template):
    return face_chart(head_template)


@pytest.fixture(scope="module")
def face(head_template):
    skin = np.random.default_rng(4).integers(60, 200, (SIZE, SIZE, 3), np.uint8)
    return Face(head_template, pictures=Pictures(skin))


@pytest.mark.parametrize(("size", "way"), [(64, cv2.INTER_AREA), (SIZE, cv2.INTER_AREA), (256, cv2.INTER_CUBIC)])
def test_a_chart_that_was_only_resized_is_not_retouched(face, chart, size, way):
    picture = texture_to_chart(face.pictures.skin, face.mesh, ChartGrid(chart, SIZE))
    resized = cv2.resize(picture, (size, size), interpolation=way)
    same = retouch_texture(face, resized, chart)
    assert same.touched == 0 and same.alike == pytest.approx(1)
    np.testing.assert_array_equal(same.texture, face.pictures.skin)
    spot = np.s_[size // 5 : size // 4, size * 2 // 5 : size // 2]
    resized[spot] = [0, 255, 0]
    spotted = retouch_texture(face, resized, chart)
    grid = ChartGrid(chart, size)
    assert spotted.touched == pytest.approx(grid.covered[spot].sum() / (grid.covered & ~grid.mouth).sum())
    assert (spotted.texture != face.pictures.skin).any(-1).mean() < 0.02
