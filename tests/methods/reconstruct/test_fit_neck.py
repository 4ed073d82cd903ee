import cv2
import numpy as np
import pytest

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.reconstruct.fit_neck import fit_neck
from caricli.structures import Camera, Face
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import POINT_NAMES
from caricli.structures.parsing import Region

SKIN, NECK, CLOTH, BACK = (200, 150, 120), (110, 70, 50), (230, 230, 235), (90, 100, 160)
SIZE = 600


def drawn(template, width, roll=0.0, shirt=Region.CLOTH):
    """A Face and its ParsedPicture: an oval head on a neck of a width, in shares of that of its own neck's edge.

    shirt: what the label map takes the shirt for that begins 30 pixels below the chin.
    """
    turn = np.array([[np.cos(roll), -np.sin(roll), 0], [np.sin(roll), np.cos(roll), 0], [0, 0, 1]])
    rotation = turn @ np.diag([1.0, -1.0, -1.0])
    scale = 300 / template.height
    middle = (template.vertices.min(0) + template.vertices.max(0)) / 2
    camera = Camera(scale, rotation, [SIZE / 2, 260] - scale * (rotation @ middle)[:2])
    straight = Camera(scale, np.diag([1.0, -1.0, -1.0]), [SIZE / 2, 260] - scale * middle[:2] * [1, -1])
    places = straight.project(template.vertices)
    chin = places[template.annotation.landmarks[POINT_NAMES["chin"]]]
    half = width * np.ptp(places[template.neck.edge, 0]) / 2
    regions = np.zeros((SIZE, SIZE), np.uint8)
    image = np.full((SIZE, SIZE, 3), BACK, np.uint8)
    x, top, low = SIZE // 2, int(chin[1]), SIZE - 1
    for colour, region, ends in ((NECK, Region.NECK, (x - half, top - 20, x + half, low)),
                                 (CLOTH, shirt, (x - 150, top + 30, x + 150, low))):  # fmt: skip
        left, first, right, last = (round(value) for value in ends)
        regions[first : last + 1, left:right] = region
        image[first : last + 1, left:right] = colour
    oval = (x, (int(places[:, 1].min()) + top) // 2), (100, (top - int(places[:, 1].min())) // 2)
    cv2.ellipse(regions, *oval, 0, 0, 360, int(Region.SKIN), -1)
    cv2.ellipse(image, *oval, 0, 0, 360, SKIN, -1)
    matrix = np.column_stack([turn[:2, :2], [SIZE / 2, 260] - turn[:2, :2] @ [SIZE / 2, 260]])
    regions = cv2.warpAffine(regions, matrix, (SIZE, SIZE), flags=cv2.INTER_NEAREST)
    image = cv2.warpAffine(image, matrix, (SIZE, SIZE), borderValue=BACK)
    return Face(template, camera), ParsedPicture(image, regions)


def width_of(face, template):
    return np.ptp(face.vertices[template.neck.edge, 0])


@pytest.mark.parametrize("roll", [0.0, 0.4])
@pytest.mark.parametrize("width", [0.4, 0.55])
def test_a_thin_neck_is_as_wide_as_it_is_seen(head_template, width, roll):
    face, picture = drawn(head_template, width, roll)
    thin, times = fit_neck(face, head_template, picture)
    assert abs(times - width) < 0.03
    assert abs(width_of(thin, head_template) / width_of(face, head_template) - width) < 0.04
    still = head_template.mask("face", "scalp", "ear_left", "ear_right")
    still &= ~(head_template.neck.weights > 1e-3)
    np.testing.assert_allclose(thin.vertices[still], face.vertices[still], atol=1e-4)
    assert flipped_triangles(thin.vertices, head_template.gradients).mean() < 1e-3


def test_a_shirt_that_is_labelled_neck_is_told_by_its_colours(head_template):
    face, picture = drawn(head_template, 0.4, shirt=Region.NECK)
    assert abs(fit_neck(face, head_template, picture)[1] - 0.4) < 0.03


@pytest.mark.parametrize("width", [0.95, 1.3])
def test_a_usual_neck_stays(head_template, width):
    face, picture = drawn(head_template, width)
    same, times = fit_neck(face, head_template, picture)
    assert same is face and times == 1


def test_where_no_neck_is_seen_it_stays(head_template):
    face, picture = drawn(head_template, 0.4)
    hidden = np.where(picture.regions == Region.SKIN, picture.regions, np.uint8(Region.CLOTH))
    for other in (ParsedPicture(picture.pixels, hidden), ParsedPicture(picture.pixels)):
        assert fit_neck(face, head_template, other) == (face, 1.0)


@pytest.mark.parametrize("side", [-1, 1])
def test_what_is_labelled_neck_beside_the_middle_is_none(head_template, side):
    face, picture = drawn(head_template, 0.4)
    chin = face.camera.project(face.vertices)[head_template.annotation.landmarks[POINT_NAMES["chin"]]].astype(int)
    bare = np.where(picture.regions == Region.SKIN, picture.regions, np.uint8(Region.CLOTH))
    patches = []
    for shift in (0, 26):
        patch = bare.copy()
        patch[chin[1] + 4 : chin[1] + 24, SIZE // 2 + side * shift - 12 : SIZE // 2 + side * shift + 12] = Region.NECK
        patches.append(fit_neck(face, head_template, ParsedPicture(picture.pixels, patch))[1])
    assert patches[0] < 0.6 and patches[1] == 1


def test_a_neck_that_goes_on_beside_the_jaw_is_no_thin_one(head_template):
    """A sweater hides all of it but a strip below the chin, and what is beside the jaw."""
    face, picture = drawn(head_template, 0.4)
    regions = picture.regions.copy()
    chin = face.camera.project(face.vertices)[head_template.annotation.landmarks[POINT_NAMES["chin"]]].astype(int)
    beside = (regions == Region.BACKGROUND) & (np.abs(np.arange(SIZE) - SIZE // 2) < 95)
    beside[: chin[1] - 80] = beside[chin[1] + 10 :] = False
    regions[beside] = Region.NECK
    image = np.where(beside[..., None], np.array(NECK, np.uint8), picture.pixels)
    assert fit_neck(face, head_template, ParsedPicture(image, regions))[1] > 0.9


@pytest.mark.parametrize("side", [-1, 1])
def test_a_neck_does_not_stand_before_what_is_behind_the_head(head_template, side):
    """A shirt hides it up to the chin, and beside the jaw, on one side, the background is seen."""
    face, picture = drawn(head_template, 0.5)
    regions = np.where(picture.regions == Region.NECK, np.uint8(Region.CLOTH), picture.regions)
    covered = (np.arange(SIZE) - SIZE // 2) * side > 0
    regions[:, covered] = np.where(regions[:, covered] == Region.BACKGROUND, Region.CLOTH, regions[:, covered])
    thin, times = fit_neck(face, head_template, ParsedPicture(picture.pixels, regions))
    edge = head_template.neck.edge
    own, now = (each.vertices[edge, 0] * side for each in (face, thin))
    assert times < 0.9 and now.min() > own.min() + 0.01 and abs(now.max() - own.max()) < 0.003


def test_of_a_head_that_is_seen_from_its_side_nothing_is_told(head_template):
    face, picture = drawn(head_template, 0.4)
    aside = np.array([[0.0, 0, -1], [0, -1, 0], [-1, 0, 0]])
    turned = Face(head_template, Camera(face.camera.scale, aside, face.camera.translation))
    assert fit_neck(turned, head_template, picture) == (turned, 1.0)
