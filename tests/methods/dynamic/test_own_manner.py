import numpy as np
import pytest

from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.own_manner import MannerReader
from caricli.template.chart import face_chart

SIDE = 64
SKIN = np.array([0.85, 0.62, 0.45])


@pytest.fixture(scope="module")
def grid(head_template):
    return ChartGrid(face_chart(head_template), SIDE)


@pytest.fixture(scope="module")
def reader(grid, head_template):
    return MannerReader(grid, head_template)


def painted(strokes):
    """Skin with darker strokes. strokes: (S, S, 3) logarithms of colours."""
    return np.rint(255 * SKIN * np.exp(strokes)).astype(np.uint8)


def test_shades_are_those_that_skin_was_painted_with(reader):
    """Noise along a line of colours is read as that line, whatever brows and lips are painted."""
    depth = -np.abs(np.random.default_rng(0).normal(0, 0.15, (SIDE, SIDE, 1)))
    red, green, blue = way = np.array([0.5, 1.2, 1.1])
    picture = painted(depth * way)
    picture[~reader.zone] = (20, 30, 160)
    read = reader.read(picture).shades
    weights = np.array([0.2126, 0.7152, 0.0722]) * SKIN
    np.testing.assert_allclose(read, way / ((weights * way).sum() / weights.sum()), atol=0.15)
    assert read[0] < read[2] < read[1] and (red < blue < green)


def test_paint_of_one_colour_takes_what_is_usual(reader):
    """Nothing is told of its shades: they are redder than it is."""
    red, green, blue = reader.read(painted(np.zeros((SIDE, SIDE, 3)))).shades
    assert red < green < blue


def test_folds_may_be_deeper_where_skin_has_deeper_shades(reader):
    noise = np.random.default_rng(1).normal(size=(SIDE, SIDE, 1))
    plain, faint, strong = (reader.read(painted(-depth * np.abs(noise))).deepest for depth in (0.0, 0.1, 0.3))
    assert 0 < plain < faint < strong
    assert plain == pytest.approx(0.02, abs=0.005)


def test_only_skin_is_looked_at(reader, grid):
    assert 0.05 < reader.zone.sum() / grid.covered.sum() < 0.9
    assert not (reader.zone & (grid.mouth | ~grid.covered)).any()
    manner = reader.read(painted(np.zeros((SIDE, SIDE, 3))))
    assert (manner.share[grid.mouth] == 0).all() and 0 < manner.share[~grid.mouth].min() <= 1
