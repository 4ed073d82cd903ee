from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import (
    ChartGrid,
    chart_to_texture,
    face_texels,
    picture_to_chart,
    texture_to_chart,
)
from caricli.structures import Camera, Face
from caricli.template.chart import face_chart

SIZE = 200


@pytest.fixture(scope="module")
def grid(head_template):
    return ChartGrid(face_chart(head_template), SIZE)


def centres(size):
    """(S, S, 2) UVs of texels' centres."""
    row, column = np.mgrid[:size, :size]
    return np.stack([(column + 0.5) / size, 1 - (row + 0.5) / size], axis=-1)


def test_linear_functions_of_the_chart_are_baked_exactly(grid, head_template):
    values = np.zeros((len(head_template.vertices), 3))
    values[grid.chart.vertices] = grid.chart.uvs @ [[1, 2, 0], [3, -1, 0]] + [0.5, 0, 1]
    baked = grid.bake(values)
    expected = centres(SIZE) @ [[1, 2, 0], [3, -1, 0]] + [0.5, 0, 1]
    assert baked.dtype == np.float32 and not baked[~grid.covered].any()
    np.testing.assert_allclose(baked[grid.covered], expected[grid.covered], atol=2e-5)


def test_no_value_hangs_on_which_corner_of_a_triangle_is_its_first(grid):
    turned = ChartGrid(grid.chart, SIZE)
    turned.chart = replace(grid.chart, faces=np.roll(grid.chart.faces, 1, axis=1))
    turned.weights = np.roll(grid.weights, 1, axis=-1)
    values = np.random.default_rng(0).normal(size=(len(grid.chart.vertices), 3))
    np.testing.assert_array_equal(turned.bake_own(values), grid.bake_own(values))


def test_the_mouth_is_where_the_membrane_is(grid):
    assert 0.01 < grid.mouth.mean() < 0.05 and (grid.covered >= grid.mouth).all()
    row, column = np.nonzero(grid.mouth)
    assert abs(column.mean() - (SIZE - 1) / 2) < 1 and row.mean() > SIZE / 2


def waves(size):
    """(S, S, 3) uint8: a smooth picture."""
    u, v = np.moveaxis(centres(size), -1, 0)
    return np.round(128 + 100 * np.stack([np.sin(9 * u), np.cos(7 * v), np.sin(5 * (u + v))], -1)).astype(np.uint8)


def test_from_the_heads_texture_to_the_chart_and_back(grid, head_template):
    picture = waves(256)
    back = chart_to_texture(texture_to_chart(picture, head_template, grid), head_template, grid, 256)
    shown = face_texels(head_template, grid, 256)
    assert back.dtype == np.uint8 and not back[~shown].any() and shown.mean() > 0.3
    error = np.abs(back[shown].astype(float) - picture[shown])
    assert error.mean() < 1.5 and np.quantile(error, 0.99) < 8


def test_from_the_chart_to_the_heads_texture_and_back(grid, head_template):
    picture = waves(SIZE).astype(np.float32)
    back = texture_to_chart(chart_to_texture(picture, head_template, grid, 1024), head_template, grid)
    skin = grid.covered & ~grid.mouth
    assert np.quantile(np.abs(back - picture)[skin], 0.95) < 3


def test_lips_of_one_colour_have_it_between_them(grid, head_template):
    picture = np.full((64, 64, 3), (200, 80, 10), np.uint8)
    np.testing.assert_array_equal(
        texture_to_chart(picture, head_template, grid), np.broadcast_to(picture[0, 0], (SIZE, SIZE, 3))
    )


def test_a_picture_is_taken_through_its_camera(grid, head_template):
    camera = Camera(1000.0, np.diag([1.0, -1.0, -1.0]), np.array([100.0, 250.0]))
    ramp = np.broadcast_to(np.arange(200, dtype=np.uint8)[None, :, None], (300, 200, 3))
    seen = picture_to_chart(ramp, Face(head_template, camera), grid)
    x = camera.place(head_template.vertices)[:, :1]
    np.testing.assert_allclose(seen[grid.covered][:, :1], grid.bake(x)[grid.covered], atol=0.51)


def test_another_mesh_and_a_mesh_without_uvs(grid, head_template):
    picture = np.zeros((8, 8, 3), np.uint8)
    other = replace(head_template, polygons=head_template.polygons[::-1], uv_polygons=head_template.uv_polygons[::-1])
    bare = replace(head_template, uvs=None, uv_polygons=None)
    for mesh, problem in ((other, "another one"), (bare, "without")):
        with pytest.raises(InputError, match=problem):
            texture_to_chart(picture, mesh, grid)
        with pytest.raises(InputError, match=problem):
            chart_to_texture(picture, mesh, grid, 64)
