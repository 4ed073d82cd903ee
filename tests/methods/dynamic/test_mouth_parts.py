import numpy as np
import pytest

from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.mouth_parts import MouthParts, look_inside
from caricli.methods.dynamic.shape_maps import CHANNELS, PersonShapes, pair_maps
from caricli.structures import Material
from caricli.template.chart import face_chart


@pytest.fixture(scope="module")
def grid(head_template):
    return ChartGrid(face_chart(head_template), 96)


@pytest.fixture(scope="module")
def smile_and_shout(head, head_template):
    shapes = [head.evaluate(actions=each) for each in ({"mouthSmileLeft": 0.4}, {"jawOpen": 0.9})]
    return np.stack(shapes) - head_template.vertices


def squares():
    """A tooth on the left, 0.1 behind the lips, before a tongue, 0.2 behind them, that reaches to the right."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    vertices = np.concatenate([square * 0.2 - [0, 0, 0.1], square * [0.4, 0.2, 1] - [0, 0, 0.2]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    return MouthParts(vertices, np.zeros((0, 8, 3)), faces, np.array([True, True, False, False]))


def test_the_nearest_is_seen_and_how_far_it_is():
    parts = squares()
    between = np.array([[0.1, 0.1, 0.05], [0.3, 0.1, 0.05], [0.5, 0.1, 0.05], [0.0, 0.3, 0.05]])
    seen = look_inside(parts, parts.vertices, between)
    np.testing.assert_allclose(seen[0], [1, 0, 0.15], atol=1e-4)
    np.testing.assert_allclose(seen[1], [0, 1, 0.25], atol=1e-4)
    np.testing.assert_allclose(seen[2:, :2], 0)
    np.testing.assert_allclose(seen[2:, 2], 0.25, atol=1e-4)
    assert look_inside(parts, parts.vertices, between[:0]).shape == (0, 3)


def test_an_edge_is_shared():
    parts = squares()
    edge = look_inside(parts, parts.vertices, np.array([[0.0, 0.0, 0.0], [0.2, 0.1, 0.0], [0.4, 0.2, 0.0]]))[1]
    assert 0.2 < edge[0] < 0.8
    assert edge[0] + edge[1] == pytest.approx(1, abs=1e-5)


def test_a_head_has_teeth_and_tongue_and_no_lashes(head_template, smile_and_shout):
    parts = MouthParts.in_face(head_template, smile_and_shout)
    assert parts.vertices.shape == parts.deltas.shape[1:]
    assert 0.2 < parts.teeth.mean() < 0.8
    np.testing.assert_array_equal(parts.moved(np.zeros(2)), parts.vertices)
    # The jaw takes the lower teeth along, and leaves the upper ones.
    down = -parts.deltas[1, :, 1]
    teeth = np.unique(parts.faces[parts.teeth])
    assert down[teeth].min() < 1e-3 < 5e-3 < down[teeth].max()
    assert MouthParts.of([]) is None


def test_an_open_mouth_shows_what_it_has(grid, head_template, smile_and_shout):
    parts = MouthParts.in_face(head_template, smile_and_shout)
    person = PersonShapes(grid, head_template.vertices, parts)
    shout = person.fields(head_template.vertices + smile_and_shout[1], np.array([0.0, 1.0]))
    rest = person.fields(head_template.vertices)
    maps = dict(zip(CHANNELS, np.moveaxis(pair_maps(grid, rest, shout), -1, 0), strict=True))
    teeth = maps["target_teeth"][grid.mouth]
    assert 0.05 < teeth.mean() < 0.7
    assert maps["target_flesh"][grid.mouth].mean() > 0.05
    assert 0.05 < np.median(maps["target_depth"][grid.mouth]) < 1
    for name in ("target_teeth", "target_flesh", "target_depth"):
        assert not maps[name][~grid.mouth].any(), name
    unmoved = person.fields(head_template.vertices + smile_and_shout[1])
    assert np.abs(unmoved.inside - shout.inside).max() > 0.5
    told_nothing = PersonShapes(grid, head_template.vertices).fields(head_template.vertices)
    assert not told_nothing.inside.any()


def test_parts_other_than_the_mouth_do_not_count(head_template):
    from caricli.methods.parts.attachment import attachment_for

    parts = attachment_for(head_template).attach(head_template)
    assert any((part.materials == Material.LASHES).any() for part in parts)
    of_all = MouthParts.of(parts)
    of_mouth = MouthParts.of([part for part in parts if not (part.materials == Material.LASHES).any()])
    np.testing.assert_array_equal(of_all.faces, of_mouth.faces)
