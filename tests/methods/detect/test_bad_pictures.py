"""What the bundled detector says of pictures that show no face, or hardly one: nothing, or that it is doubtful."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from skimage import data

import caricli
from caricli.errors import InputError
from caricli.io.image import read_image
from caricli.io.landmarks import read_landmarks
from caricli.methods.detect.see_face import see_face
from caricli.store.detector import load_detector
from caricli.structures import Camera, Pictures, Rig
from tests.drawn_albedo import soft_skin
from tests.textured_pictures import render_textured

ROOT = Path(caricli.__file__).parents[1]
FAR = 8.0  # percent of the diagonal, from which on landmarks are another face's


@pytest.fixture(scope="module")
def detector():
    return load_detector()


@pytest.fixture(scope="module")
def portrait():
    """A photograph, and the 68 landmarks of its face."""
    marks = read_landmarks(ROOT / "examples" / "astronaut" / "landmarks.json")
    return data.astronaut(), marks.points


def error(seen, points):
    """Mean distance of landmarks in percent of their diagonal."""
    away = np.linalg.norm(seen.landmarks.points[:68] - points, axis=1)
    return 100 * np.nanmean(away) / np.linalg.norm(np.ptp(points, axis=0))


def seen_or_refused(pixels, detector):
    """The SeenFace of a picture, or None where it is refused in clear words."""
    try:
        return see_face(np.ascontiguousarray(pixels), detector)
    except InputError as refusal:
        assert "expected a face, found none" in str(refusal)
        return None


def shrunk(picture, side):
    return cv2.resize(picture, (side, side), interpolation=cv2.INTER_AREA)


def test_of_several_faces_smaller_than_a_twelfth_each_is_seen(detector, portrait):
    corners = np.array([(x, y) for x in (100, 550) for y in (100, 550)])
    picture = np.full((1000, 1000, 3), 150, np.uint8)
    for x, y in corners:
        picture[y : y + 358, x : x + 358] = shrunk(portrait[0], 358)
    seen = see_face(picture, detector)
    assert seen.doubt is None and seen.others == len(corners) - 1
    truths = (portrait[1] + 0.5) * 358 / 512 - 0.5 + corners[:, None]
    assert min(error(seen, truth) for truth in truths) < 4


def test_a_face_is_seen_without_doubt(detector, portrait):
    seen = see_face(portrait[0], detector)
    assert error(seen, portrait[1]) < 4 and seen.doubt is None and seen.others == 0


def logo():
    paper = np.full((240, 240, 3), 255, np.uint8)
    cv2.circle(paper, (120, 120), 90, (200, 30, 40), -1)
    cv2.circle(paper, (120, 120), 60, (255, 255, 255), -1)
    cv2.putText(paper, "ACME", (72, 132), cv2.FONT_HERSHEY_SIMPLEX, 1.1, (30, 30, 30), 4)
    return paper


NOTHING = {
    "logo": logo,
    "cat": data.chelsea,
    "cup": data.coffee,
    "coins": lambda: np.repeat(data.coins()[..., None], 3, 2),
    "noise": lambda: np.random.default_rng(0).integers(0, 256, (200, 300, 3), np.uint8),
    "paper": lambda: np.full((200, 300, 3), 255, np.uint8),
    "pixel": lambda: np.full((1, 1, 3), 90, np.uint8),
    "ribbon": lambda: np.random.default_rng(0).integers(0, 256, (20, 20000, 3), np.uint8),
}


@pytest.mark.parametrize("name", NOTHING)
def test_what_is_no_face_is_refused(name, detector):
    assert seen_or_refused(NOTHING[name](), detector) is None


def test_of_four_faces_the_largest_is_taken_and_the_others_are_told(detector, portrait):
    picture, points = portrait
    face = picture[0:260, 90:350]
    wall = np.full((640, 640, 3), 120, np.uint8)
    for x, y, side in ((0, 0, 260), (300, 0, 240), (0, 300, 240), (270, 270, 360)):
        wall[y : y + side, x : x + side] = shrunk(face, side)
    seen = see_face(wall, detector)
    assert error(seen, (points - [90, 0]) * 360 / 260 + 270) < FAR and seen.others == 3


def sunglasses(picture, points):
    worn = picture.copy()
    for eye in (points[36:42], points[42:48]):
        width = float(np.ptp(eye[:, 0]))
        cv2.ellipse(worn, (eye.mean(0).tolist(), (2.1 * width, 1.5 * width), 0), (15, 15, 20), -1)
    return worn, points


def line_art(picture, points):
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY).astype(float)
    edges = cv2.GaussianBlur(grey, (0, 0), 1.0) - 0.98 * cv2.GaussianBlur(grey, (0, 0), 1.6)
    ink = np.where(edges < np.quantile(edges, 0.08), 0, 255).astype(np.uint8)
    return np.repeat(ink[..., None], 3, 2), points


def of_twenty_pixels(picture, points):
    small = np.full((300, 300, 3), 150, np.uint8)
    small[100:205, 100:205] = shrunk(picture, 105)
    return small, points * 105 / 512 + 100


HARD = {
    "sunglasses": sunglasses,
    "line art": line_art,
    "twenty pixels": of_twenty_pixels,
    "cut at the chin": lambda picture, points: (picture[: int(points[57, 1]) + 4], points),
    "upside down": lambda picture, points: (picture[::-1, ::-1], 511 - points),
}


@pytest.mark.parametrize("name", HARD)
def test_a_face_that_is_hard_to_see_is_never_confidently_wrong(name, detector, portrait):
    pixels, points = HARD[name](*portrait)
    seen = seen_or_refused(pixels, detector)
    assert seen is None or seen.doubt or error(seen, points) < FAR


def test_a_profile_is_never_confidently_wrong(detector, head, head_template):
    vertices = head.evaluate(gender=0.3, age=0.6)
    skin = soft_skin(head_template)
    mesh = head_template.with_vertices(vertices.astype(np.float32))
    rig = Rig((), mesh, np.zeros((0, *vertices.shape), np.float32), pictures=Pictures(skin))
    turn = np.radians(80)
    aside = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    camera = Camera(1050.0, np.diag([1.0, -1, -1]) @ aside, np.array([150.0, 290.0]))
    pixels = render_textured(rig, camera.place(vertices), 300, 300, paper=np.array([60.0, 90, 160]))
    points = camera.project(vertices[list(head_template.annotation.landmarks[:68])])
    seen = seen_or_refused(pixels, detector)
    assert seen is None or seen.doubt or error(seen, points) < 2 * FAR


def save_turned(picture, path):
    orientation = Image.Exif()
    orientation[0x0112] = 6
    picture.rotate(90, expand=True).save(path, exif=orientation)


KINDS = {
    "cmyk.jpg": lambda picture, path: picture.convert("CMYK").save(path, quality=95),
    "alpha.png": lambda picture, path: picture.convert("RGBA").save(path),
    "turned.jpg": save_turned,
    "film.gif": lambda picture, path: picture.save(path, save_all=True, append_images=[picture.convert("L")]),
}


@pytest.mark.parametrize("name", KINDS)
def test_pictures_of_all_kinds_show_the_same_face(name, detector, portrait, tmp_path):
    KINDS[name](Image.fromarray(portrait[0]), tmp_path / name)
    assert error(see_face(read_image(tmp_path / name), detector), portrait[1]) < 4


def test_sixteen_grey_bits_are_never_confidently_wrong(detector, portrait, tmp_path):
    grey = np.asarray(Image.fromarray(portrait[0]).convert("L")).astype(np.uint16) * 257
    Image.fromarray(grey).save(tmp_path / "sixteen.png")
    seen = seen_or_refused(read_image(tmp_path / "sixteen.png"), detector)
    assert seen is None or seen.doubt or error(seen, portrait[1]) < FAR
