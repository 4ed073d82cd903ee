import pytest

from caricli.render.face_sheet import SheetSettings, face_sheet
from caricli.structures import Mesh


@pytest.fixture
def mesh(ball):
    vertices, faces = ball
    return Mesh(0.1 * vertices, faces)


def test_the_views_of_one_face_are_in_a_row(mesh):
    settings = SheetSettings(("front", "profile"), size=24)
    assert settings.count == 2
    picture = face_sheet([mesh], ["ball"], settings)
    assert picture.shape[1] > 2 * 24 > picture.shape[0] >= 24
    column = face_sheet([mesh], ["ball"], SheetSettings(("front", "profile"), size=24, columns=1))
    assert column.shape[0] > 2 * 24 > column.shape[1]


def test_several_faces_have_names(mesh):
    settings = SheetSettings(("front",), size=24, columns=2)
    one = face_sheet([mesh], ["ball"], settings)
    assert face_sheet([mesh, mesh], ["one", "two"], settings).shape[0] > one.shape[0]


def test_a_turn(mesh):
    settings = SheetSettings(frames=4, size=24)
    assert settings.count == 4
    picture = face_sheet([mesh], ["ball"], settings)
    assert picture.shape[0] > 2 * 24 and picture.shape[1] > 2 * 24
