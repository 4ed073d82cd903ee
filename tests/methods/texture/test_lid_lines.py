from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial import KDTree

from caricli.geometry.lines.along_lines import along
from caricli.methods.texture.lid_lines import LidLine, draw_lid_lines, seen_lid_line
from caricli.methods.texture.paint_head import paint_head
from caricli.methods.texture.settings import PaintSettings
from caricli.render.visibility.uv_map import uv_map

SKIN, WHITE, IRIS, INK = (205, 165, 140), (235, 230, 225), (50, 30, 20), (30, 20, 25)
MIDDLES = ((120, 100), (280, 100))
HALF = np.array([50, 18])


def drawing(thick=None, colour=INK):
    """Two eyes, the line along their upper lids so many pixels thick."""
    image = np.full((200, 400, 3), SKIN, np.uint8)
    for middle in MIDDLES:
        cv2.ellipse(image, middle, HALF.tolist(), 0, 0, 360, WHITE, -1)
        cv2.circle(image, middle, 16, IRIS, -1)
        if thick is not None:
            cv2.ellipse(image, middle, HALF.tolist(), 0, 180, 360, colour, thick)
    return image


def marks():
    points = np.random.default_rng(0).uniform(0, 100, (68, 2))
    angles = np.radians([180, 240, 300, 0, 60, 120])
    for first, middle in zip((36, 42), MIDDLES, strict=True):
        points[first : first + 6] = middle + HALF * np.stack([np.cos(angles), np.sin(angles)], 1)
    return points


def test_a_line_has_its_colour_and_width():
    thin, thick = (seen_lid_line(drawing(each), marks()) for each in (5, 13))
    for line in (thin, thick):
        assert line.strength == 1
        np.testing.assert_allclose(line.colour, INK, atol=12)
    assert thin.width == pytest.approx(5 / 100, abs=0.015) and 0.075 < thick.width <= 0.09


def test_eyes_without_lines_have_none():
    assert seen_lid_line(drawing(), marks()) is None
    assert seen_lid_line(drawing(5, (160, 125, 105)), marks()) is None


def test_a_faint_line_counts_in_part():
    line = seen_lid_line(drawing(7, (85, 65, 55)), marks())
    assert 0.2 < line.strength < 0.8


def test_an_eye_without_a_line_lends_it_no_colour():
    image = drawing(7)
    image[:, 200:] = drawing()[:, 200:]
    line = seen_lid_line(image, marks())
    assert line.strength == pytest.approx(0.5, abs=0.05)
    np.testing.assert_allclose(line.colour, INK, atol=12)


@pytest.mark.parametrize("points", [np.full((68, 2), np.nan), np.zeros((68, 2)), marks() + 1000])
def test_nothing_is_told_of_eyes_that_are_not_seen(points):
    assert seen_lid_line(drawing(7), points) is None


def colours_at(picture, head, vertices):
    """Colours of vertices in a texture."""
    order = np.argsort(head.faces.ravel(), kind="stable")
    first = order[np.searchsorted(head.faces.ravel()[order], vertices)]
    u, v = head.uvs[head.uv_faces.ravel()[first]].T
    return picture[((1 - v) * len(picture)).astype(int), (u * len(picture)).astype(int)]


def test_it_is_drawn_along_upper_lids_alone(head, head_template):
    shape = head_template.with_vertices(head.evaluate())
    plain = np.full((1024, 1024, 3), SKIN, np.uint8)
    drawn = draw_lid_lines(plain, shape, LidLine(np.array(INK, float), 1.0, 0.05))
    changed = (drawn != plain).any(-1)
    assert 200 < changed.sum() < 5000
    for side in ("left", "right"):
        upper, lower = (np.array(shape.annotation.curves[f"eye_{lid}_{side}"]) for lid in ("upper", "lower"))
        np.testing.assert_allclose(colours_at(drawn, shape, upper[4:-4]), np.tile(INK, (7, 1)), atol=12)
        np.testing.assert_array_equal(colours_at(drawn, shape, lower[4:-4]), np.tile(SKIN, (7, 1)))
    faint = draw_lid_lines(plain, shape, LidLine(np.array(INK, float), 0.5, 0.05))
    assert (faint >= drawn).all() and (faint > drawn).any() and (faint[changed] < plain[changed]).any()


def test_it_ends_as_points_and_is_not_drawn_in_sockets(head, head_template):
    shape = head_template.with_vertices(head.evaluate())
    plain = np.full((1024, 1024, 3), SKIN, np.uint8)
    drawn = draw_lid_lines(plain, shape, LidLine(np.array(INK, float), 1.0, 0.09))
    face, weights = uv_map(shape, 1024)
    rows, columns = np.nonzero((drawn != plain).any(-1) & (face >= 0))
    faces = shape.faces[face[rows, columns]]
    assert not shape.mask("eye_socket_left", "eye_socket_right")[faces].all(1).any()
    places = np.einsum("nk,nkc->nc", weights[rows, columns], shape.vertices[faces])
    lid = shape.vertices[shape.annotation.curves["eye_upper_left"]]
    away, share = KDTree(along(lid[None], np.linspace(0, 1, 101)[None])[0]).query(places[places[:, 0] > 0])
    ends = np.minimum(share, 100 - share)
    assert away[ends < 4].max() < 0.6 * away[ends > 15].max()


def test_where_no_lids_are_named_there_is_no_line(head_template):
    annotation = replace(head_template.annotation, curves={})
    plain = np.full((256, 256, 3), SKIN, np.uint8)
    line = LidLine(np.array(INK, float), 1.0, 0.05)
    np.testing.assert_array_equal(draw_lid_lines(plain, replace(head_template, annotation=annotation), line), plain)


def test_a_painted_head_has_the_line_of_its_picture(pictured):
    image = pictured.image.copy()
    lids = [pictured.face.landmarks[list(eye)] for eye in ((36, 37, 38, 39), (42, 43, 44, 45))]
    cv2.polylines(image, [np.round(lid).astype(np.int32) for lid in lids], False, INK, 2)
    settings = PaintSettings(size=512, hair="none")
    upper = np.array(pictured.head.annotation.curves["eye_upper_left"])[4:-4]
    before, after = (
        colours_at(
            paint_head(pictured.face, pictured.head, picture, pictured.mask, settings).pictures.skin,
            pictured.head,
            upper,
        )
        for picture in (pictured.image, image)
    )
    assert after.mean() < 0.6 * before.mean()
