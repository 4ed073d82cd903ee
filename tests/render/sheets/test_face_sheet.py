import pytest

from caricli.render.sheets.face_sheet import SheetSettings, face_sheet
from caricli.structures import Face, Mesh


@pytest.fixture
def face(ball):
    vertices, faces = ball
    return Face(Mesh(0.1 * vertices, faces))


def test_the_views_of_one_face_are_in_a_row(face):
    settings = SheetSettings(("front", "profile"), size=24)
    assert settings.count == 2
    picture = face_sheet([face], ["ball"], settings)
    assert picture.shape[1] > 2 * 24 > picture.shape[0] >= 24
    column = face_sheet([face], ["ball"], SheetSettings(("front", "profile"), size=24, columns=1))
    assert column.shape[0] > 2 * 24 > column.shape[1]


def test_several_faces_have_names(face):
    settings = SheetSettings(("front",), size=24, columns=2)
    one = face_sheet([face], ["ball"], settings)
    assert face_sheet([face, face], ["one", "two"], settings).shape[0] > one.shape[0]


def test_a_turn(face):
    settings = SheetSettings(frames=4, size=24)
    assert settings.count == 4
    picture = face_sheet([face], ["ball"], settings)
    assert picture.shape[0] > 2 * 24 and picture.shape[1] > 2 * 24
