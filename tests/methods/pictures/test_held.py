import cv2
import numpy as np
import pytest

from caricli.methods.pictures.held import hold_before
from caricli.structures.parsing import Region
from tests.drawn_pictures import mean_shape


def test_what_is_held_covers_a_part_of_a_face_and_is_labelled(head_template):
    points = 100 + 200 * mean_shape(head_template) / np.ptp(mean_shape(head_template))
    points = points - points.mean(0) + 150
    covered = []
    for seed in range(30):
        image = np.full((300, 300, 3), 0.5, np.float32)
        region = np.full((300, 300), Region.SKIN, np.uint8)
        hold_before(image, region, points, np.array([0.9, 0.5, 0.3]), np.random.default_rng(seed))
        other = region == Region.OTHER
        assert set(np.unique(region)) <= {Region.SKIN, Region.OTHER} and other.any()
        assert np.abs(image - 0.5).max(2)[other].mean() > 0.02
        changed = np.abs(image - 0.5).max(2) > 1e-3
        # Its border is smooth: half a pixel of it on either side.
        assert (changed & ~other).sum() < 0.25 * other.sum() + 60
        at = np.round(points).astype(int)
        covered.append(other[at[:, 1], at[:, 0]].mean())
    assert 0.05 < np.mean(covered) < 0.7


SKIN = np.array([2.0, 1.5, 1.0])
PAPER = 0.5


@pytest.fixture(scope="module")
def points(head_template):
    """Of a face right of the middle of a picture and low in it."""
    shape = mean_shape(head_template)
    shape = 80 * (shape - shape.mean(0)) / np.ptp(shape[:68], axis=0).max()
    return shape + [120, 150]


@pytest.fixture(scope="module")
def held(points):
    """Pictures (S, S, 3) and Regions (S, S) of things before it, by their kinds: they are told by their colours."""
    things = {"hand": [], "microphone": [], "thing": []}
    for seed in range(50):
        image = np.full((260, 260, 3), PAPER, np.float32)
        region = np.full((260, 260), Region.SKIN, np.uint8)
        hold_before(image, region, points, SKIN, np.random.default_rng(seed))
        tone = image[region == Region.OTHER].max(0)
        grey = np.ptp(tone) < 1e-5
        hand = np.ptp(tone / SKIN) < 1e-5
        things["microphone" if grey else "hand" if hand else "thing"].append((image, region == Region.OTHER))
    return things


def test_half_of_what_is_held_are_hands_in_the_colour_of_the_skin(held):
    assert 15 < len(held["hand"]) < 35 and min(len(held["microphone"]), len(held["thing"])) > 6


def depths(mask):
    """Pixels to the border of a thing."""
    return cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)


def test_what_is_held_is_dark_at_its_border_which_is_soft(held):
    for image, mask in held["hand"]:
        inside = image.max(2) / image.max()
        assert np.median(inside[(depths(mask) > 0.5) & (depths(mask) < 1.5)]) < 0.8
        assert np.median(inside[depths(mask) > 4]) > 0.99
        assert image[..., 0].min() > PAPER - 1e-5, "a mixture of paper and a bright hand is no darker than either"
        soft = np.abs(image - PAPER).max(2)[cv2.dilate(mask.astype(np.uint8), np.ones((3, 3))) > mask]
        assert (soft > 1e-3).mean() > 0.2 and (soft < 0.5).all()


def test_microphones_are_held_from_below_to_the_mouth(held, points):
    box = np.ptp(points[:68], axis=0).max()
    lip = points[57]
    for _, mask in held["microphone"]:
        depth = depths(mask)
        assert depth.max() == pytest.approx(0.11 * box, abs=2), "a ball"
        ball = np.argwhere(depth > depth.max() - 0.5).mean(0)[::-1]
        assert -2 < ball[1] - lip[1] < 0.35 * box + 2 and abs(ball[0] - lip[0]) < 0.6 * box
        assert np.argwhere(mask).mean(0)[0] > ball[1] + 0.05 * box, "its handle is below"


def test_hands_have_fingers_and_arms_and_are_as_large_as_hands(held, points):
    box = np.ptp(points[:68], axis=0).max()
    solid = []
    for _, mask in held["hand"]:
        outline = max(cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0], key=len)
        solid.append(mask.sum() / cv2.contourArea(cv2.convexHull(outline)))
        away = np.linalg.norm(outline[:, 0] - np.array(points[:68].mean(0)), axis=1).min()
        assert away < 0.75 * box
        long = max(cv2.minAreaRect(outline)[1])
        assert 0.5 * box < long < 2.2 * box
    assert 0.35 < np.median(solid) < 0.8
