import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.backdrop import PAPER
from caricli.render.sheets.fit_sheet import FITTED, GIVEN, fit_sheet
from caricli.structures import Camera, Face

FRONT = np.diag([1.0, -1.0, -1.0])
SIZE = 96


@pytest.fixture(scope="module")
def fitted(lopsided_head):
    """A Template, a Face of it whose camera shows it about (300, 200), and given landmarks."""
    camera = Camera(50.0, FRONT, np.array([300.0, 200.0]))
    vertices = lopsided_head.vertices
    front = np.flatnonzero(vertices[:, 2] > 0.3)
    points = camera.project(vertices[front[np.linspace(0, len(front) - 1, 68).astype(int)]])
    given = points + np.array([4.0, 0.0])
    given[2] = np.nan
    return lopsided_head, Face(lopsided_head, camera, points), given


def panels(sheet):
    width = sheet.shape[1] // 5
    return [sheet[:, k * width : (k + 1) * width].astype(int) for k in range(5)]


def near(panel, colour, tolerance=40):
    return np.abs(panel - colour).sum(-1) < tolerance


def sheet_of(fitted, image=None, shift=0.0, zoom=1.0):
    head, face, given = fitted
    camera = Camera(face.camera.scale * zoom, FRONT, face.camera.translation * zoom + shift)
    moved = Face(face.mesh, camera, face.landmarks * zoom + shift)
    return fit_sheet(moved, head, given * zoom + shift, image, SIZE)


def test_five_panels_none_of_them_empty(fitted):
    sheet = sheet_of(fitted)
    assert sheet.dtype == np.uint8 and sheet.ndim == 3 and sheet.shape[2] == 3
    assert SIZE <= sheet.shape[0] < 1.5 * SIZE and 5 * SIZE <= sheet.shape[1] < 6 * SIZE
    for panel in panels(sheet):
        assert (~near(panel, (255, 255, 255))).mean() > 0.02


def test_landmarks_are_marked_in_the_first_panel_only(fitted):
    first, *others = panels(sheet_of(fitted))
    assert near(first, GIVEN).sum() >= 10 and near(first, FITTED).sum() >= 10
    assert not any(near(panel, GIVEN).any() for panel in others)


def test_the_face_lies_where_its_landmarks_are(fitted):
    first, over, *_ = panels(sheet_of(fitted))
    drawn = ~near(over, (255, 255, 255))
    y, x = np.nonzero(near(first, FITTED))
    assert drawn[y, x].mean() > 0.9


def test_the_picture_is_cut_out_around_the_landmarks(fitted):
    image = np.zeros((400, 600, 3), np.uint8)
    image[:, :300] = 10, 60, 250
    image[:, 300:] = 250, 240, 10
    first = panels(sheet_of(fitted, image))[0]
    blue, yellow = near(first, (10, 60, 250)), near(first, (250, 240, 10))
    assert blue.mean() > 0.15 and yellow.mean() > 0.15
    assert np.nonzero(blue)[1].mean() < SIZE / 2 < np.nonzero(yellow)[1].mean()


def test_landmarks_beyond_the_border_of_the_picture_have_paper_behind_them(fitted):
    image = np.full((100, 100, 3), 90, np.uint8)
    sheet = sheet_of(fitted, image)
    assert near(panels(sheet)[0], PAPER).mean() > 0.3
    assert near(panels(sheet)[0], FITTED).sum() >= 10


def test_size_and_place_of_the_picture_do_not_matter(fitted):
    a, b = sheet_of(fitted).astype(int), sheet_of(fitted, zoom=4.0, shift=1000.0).astype(int)
    assert a.shape == b.shape
    assert (np.abs(a - b).max(-1) > 40).mean() < 0.01


def test_inputs_stay_as_they_are(fitted):
    head, face, given = fitted
    image = np.full((60, 60, 3), 7, np.uint8)
    arrays = face.vertices, given, face.landmarks, face.camera.translation, image
    copies = [np.copy(a) for a in arrays]
    fit_sheet(face, head, given, image, SIZE)
    for before, after in zip(copies, arrays, strict=True):
        np.testing.assert_array_equal(before, after)


def test_a_face_that_was_never_fitted_is_refused(fitted):
    head, face, given = fitted
    with pytest.raises(InputError, match="with fitted landmarks"):
        fit_sheet(Face(head, face.camera), head, given)
    with pytest.raises(InputError, match="with the camera"):
        fit_sheet(Face(head, landmarks=face.landmarks), head, given)
