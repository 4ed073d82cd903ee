import numpy as np

from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.show_mouth import show_mouth
from caricli.structures import Camera, Face
from caricli.template.chart import face_chart
from caricli.template.head import load_head


def test_open_lips_show_the_picture_and_closed_ones_the_texture():
    head = load_head()
    template = head.template()
    grid = ChartGrid(face_chart(template), 64)
    camera = Camera(1500.0, np.diag([1.0, -1, -1]), np.array([200.0, 250]))
    picture = np.full((500, 400, 3), 200, np.uint8)
    texture = np.full((64, 64, 3), 90, np.uint8)
    texture[np.flatnonzero(grid.mouth.any(1))[0]] = 10  # what was left between closed lips by chance
    for weight, colour in ((0.0, 90), (0.9, 200)):
        vertices = head.evaluate(actions={"jawOpen": weight})
        shown = show_mouth(texture, picture, Face(template.with_vertices(vertices), camera), grid)
        np.testing.assert_array_equal(shown[~grid.mouth], texture[~grid.mouth])
        assert (shown[grid.mouth] >= 90).all()
        assert np.median(shown[grid.mouth]) == colour
