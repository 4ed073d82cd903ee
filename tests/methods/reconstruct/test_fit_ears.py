import cv2
import numpy as np
import pytest

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.reconstruct.fit_ears import fit_ears
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera, Face
from caricli.structures.detection import ParsedPicture
from caricli.structures.parsing import Region
from caricli.template.annotation import EARS

SIZE = 640


@pytest.fixture(scope="module")
def face(head_template):
    scale = 420 / head_template.height
    rotation = np.diag([1.0, -1.0, -1.0])
    middle = (head_template.vertices.min(0) + head_template.vertices.max(0)) / 2
    return Face(head_template, Camera(scale, rotation, SIZE / 2 - scale * (rotation @ middle)[:2]))


def shown_ears(face, template):
    """(SIZE, SIZE) values of Region, as the head shows itself to its camera."""
    raster = rasterise(face.camera.place(face.vertices), face.faces, SIZE, SIZE)
    covered = raster.face >= 0
    ears = template.mask(*EARS)[face.faces].all(1)
    return np.where(covered, np.where(ears[raster.face], int(Region.EARS), int(Region.SKIN)), 0).astype(np.uint8)


def larger(regions, factor, aside):
    """Regions whose ears are so many times as large about where they begin, or go so many pixels farther aside."""
    drawn = np.where(regions == Region.EARS, np.uint8(Region.BACKGROUND), regions)
    for side, sign in (("left", -1), ("right", 1)):
        half = np.zeros(regions.shape, bool)
        half[:, SIZE // 2 :] = side == "right"
        half[:, : SIZE // 2] = side == "left"
        ear = ((regions == Region.EARS) & half).astype(np.uint8)
        _, columns = np.nonzero(ear)
        root = columns.max() if sign < 0 else columns.min()
        row = np.nonzero(ear)[0].mean()
        matrix = np.array([[factor, 0, root * (1 - factor) + sign * aside], [0, factor, row * (1 - factor)]], float)
        drawn[(cv2.warpAffine(ear, matrix, (SIZE, SIZE)) > 0) & (drawn == 0)] = Region.EARS
        if aside:
            drawn[(ear > 0) & (drawn == 0)] = Region.EARS
    return drawn


def picture(regions):
    return ParsedPicture(np.zeros((SIZE, SIZE, 3), np.uint8), regions)


def overlap(first, second):
    ears = [regions == Region.EARS for regions in (first, second)]
    return (ears[0] & ears[1]).sum() / (ears[0] | ears[1]).sum()


@pytest.mark.parametrize(("factor", "aside"), [(1.4, 0), (1.0, 12), (0.75, 0)])
def test_ears_get_the_outline_that_is_labelled(face, head_template, factor, aside):
    own = shown_ears(face, head_template)
    drawn = larger(own, factor, aside)
    fitted = fit_ears(face, head_template, picture(drawn))
    before, after = overlap(own, drawn), overlap(shown_ears(fitted, head_template), drawn)
    assert before < 0.75 and after > before + 0.12
    ears = head_template.mask(*EARS)
    np.testing.assert_array_equal(fitted.vertices[~ears], face.vertices[~ears])
    moved = fitted.vertices - face.vertices
    assert np.abs(moved[ears]).max() > 0.003 and np.abs(moved[:, 2]).max() < 1e-9
    assert flipped_triangles(fitted.vertices, head_template.gradients).sum() == 0


def test_ears_that_end_where_they_are_drawn_hardly_move(face, head_template):
    fitted = fit_ears(face, head_template, picture(shown_ears(face, head_template)))
    assert np.linalg.norm(fitted.vertices - face.vertices, axis=1).max() < 0.005 * head_template.height


def test_hair_that_covers_an_ear_does_not_pull(face, head_template):
    """Its border with hair is none of the ear's."""
    drawn = larger(shown_ears(face, head_template), 0.75, 0)
    hairy = np.where(drawn == Region.BACKGROUND, np.uint8(Region.HAIR), drawn)
    assert fit_ears(face, head_template, picture(hairy)) is face


def test_what_is_no_ear_of_this_head_is_left_alone(face, head_template):
    own = shown_ears(face, head_template)
    tiny = np.zeros_like(own)
    tiny[300:304, 20:24] = Region.EARS
    none = np.where(own == Region.EARS, np.uint8(Region.SKIN), own)
    for regions in (tiny, none, None):
        assert fit_ears(face, head_template, picture(regions)) is face
