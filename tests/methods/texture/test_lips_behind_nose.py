import numpy as np

from caricli.methods.texture.lips_behind_nose import lips_behind_nose
from caricli.structures import Camera
from caricli.structures.parsing import Region

CAMERA = Camera(1000.0, np.diag([1.0, -1, -1]), np.array([150.0, 200.0]))


def test_it_is_where_a_nose_is_drawn_over_lips(head_template):
    lip = CAMERA.project(head_template.vertices[head_template.annotation.landmarks[51]])
    regions = np.full((400, 300), Region.SKIN, np.uint8)
    assert not lips_behind_nose(head_template, CAMERA, regions).any()
    regions[: int(lip[1]) + 3] = Region.NOSE
    rows, columns = lips_behind_nose(head_template, CAMERA, regions).nonzero()
    corners = CAMERA.project(head_template.vertices[head_template.annotation.landmarks[[48, 54]]])
    assert len(rows) > 10 and rows.max() == int(lip[1]) + 2
    assert corners[0, 0] - 5 < columns.min() and columns.max() < corners[1, 0] + 5
