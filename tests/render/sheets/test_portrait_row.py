import numpy as np
import pytest

from caricli.render.backdrop import PAPER
from caricli.render.sheets.portrait_row import SIDES, portrait_row
from caricli.structures import Camera, Face, Pictures, Rig

SIZE = 64


@pytest.fixture(scope="module")
def row(head_template):
    """The picture, a face that was fitted, one that was not, and the textured head."""
    camera = Camera(350.0, np.diag([1.0, -1, -1]), np.array([64.0, 64 + 350 * head_template.vertices[:, 1].mean()]))
    points = camera.project(head_template.vertices[head_template.annotation.landmarks[:68]])
    points[5] = np.nan
    image = np.full((128, 96, 3), (40, 80, 160), np.uint8)
    texture = np.full((8, 8, 3), (200, 20, 20), np.uint8)
    still = np.zeros((0, *head_template.vertices.shape), np.float32)
    rig = Rig(
        (), head_template.with_vertices(head_template.vertices.astype(np.float32)), still, pictures=Pictures(texture)
    )
    face = Face(head_template, camera, np.nan_to_num(points, nan=20.0))
    return portrait_row(image, points, [(face, head_template), None], rig, SIZE)


def test_every_picture_has_the_size_that_was_asked_for(row):
    assert len(row) == 3 + len(SIDES)
    assert all(picture.shape == (SIZE, 48, 3) for picture in row[:3])
    assert all(picture.shape == (SIZE, SIZE, 3) for picture in row[3:])


def test_a_fit_is_on_paper_and_one_that_is_missing_is_the_picture_itself(row):
    picture, fit, missing, *sides = row
    assert (picture == (40, 80, 160)).all() and np.array_equal(missing, picture)
    assert (fit[0, 0] == PAPER).all() and fit.std() > 10
    assert all((side.reshape(-1, 3)[:, 0] > side.reshape(-1, 3)[:, 2] + 50).mean() > 0.1 for side in sides)
