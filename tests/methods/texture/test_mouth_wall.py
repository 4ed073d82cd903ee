from dataclasses import replace

import numpy as np

from caricli.methods.texture.mouth_wall import MOUTH, mouth_wall, wall_colour, wall_pixels
from caricli.structures import Camera


def test_it_begins_behind_the_lips(head_template):
    wall = mouth_wall(head_template)
    inside = head_template.mask("inner_mouth")
    assert (wall[~inside] == 0).all() and (wall[inside] == 1).mean() > 0.5
    corners = wall[head_template.faces]
    assert (corners.max(1) - corners.min(1)).max() < 0.5


def test_a_head_without_a_mouth_has_none(head_template):
    regions = {name: ids for name, ids in head_template.annotation.regions.items() if name != "inner_mouth"}
    head = replace(head_template, annotation=replace(head_template.annotation, regions=regions))
    assert not mouth_wall(head).any()


def test_it_is_seen_where_the_mouth_is_open(head, head_template):
    camera = Camera(1000.0, np.diag([1.0, -1, -1]), np.array([150.0, 200.0]))
    shut, wide = (
        wall_pixels(head_template.with_vertices(head.evaluate(actions=actions)), camera, (300, 400))
        for actions in ({}, {"jawOpen": 1.0})
    )
    assert shut.shape == (400, 300) and shut.sum() < 0.2 * wide.sum()
    lips = camera.project(head.evaluate(actions={"jawOpen": 1.0})[head_template.annotation.landmarks[60:68]])
    rows, columns = wide.nonzero()
    assert len(rows) > 100
    assert lips[:, 0].min() - 1 <= columns.min() and columns.max() <= lips[:, 0].max() + 1
    assert lips[:, 1].min() - 1 <= rows.min() and rows.max() <= lips[:, 1].max() + 1


def test_its_colour_is_that_of_gums_in_shadow_and_grey_in_a_grey_head():
    tan = np.tile([206.0, 160, 136], (9, 1))
    np.testing.assert_array_equal(wall_colour(tan), MOUTH)
    # A grey picture that was saved with few colours is hardly ever grey to the bit.
    near = np.full((9, 3), 120.0) + [1, 0, -1]
    np.testing.assert_allclose(wall_colour(near), MOUTH.mean())
