"""Drawings photographed on paper: what was drawn comes back, and what is no drawing is refused."""

from functools import partial
from pathlib import Path

import cv2
import numpy as np
import pytest
import skimage
from scipy.spatial import KDTree

from caricli.errors import InputError
from caricli.io.image import read_image
from caricli.methods.sketch.clean_drawing import clean_drawing
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.structures import StrokeKind
from caricli.template.feature_curves import feature_curves

SIDE = 700


@pytest.fixture(scope="module")
def sketch(head_template):
    curves = feature_curves(head_template.annotation)
    return draw_sketch(head_template.vertices, curves, canvas_camera(head_template.vertices, curves))


def photograph(sketch, generator, darkness=0.7, width=3.0, table=None, fall=0.35):
    """Lines on paper with a lamp on one side, a shadow, grain, a soft lens, JPEG; on a table, or close up."""
    ink = rasterise_sketch(sketch, SIDE, width) / 255
    y, x = np.mgrid[:SIDE, :SIDE] / SIDE
    spot = np.exp(-((x - generator.uniform()) ** 2 + (y - generator.uniform()) ** 2) / 0.05)
    light = 0.85 - fall * x + 0.1 * y - 0.25 * spot
    picture = (light * (1 - darkness * ink))[..., None] * [1.0, 0.96, 0.88]
    picture = cv2.GaussianBlur(picture, (0, 0), 0.8)
    grain = generator.normal(0, 0.015, (SIDE, SIDE)) + cv2.GaussianBlur(
        generator.normal(0, 0.04, (SIDE, SIDE)), (0, 0), 2
    )
    picture += grain[..., None]
    if table is not None:
        whole = np.full((SIDE + 200, SIDE + 240, 3), table) + generator.normal(0, 0.02, (SIDE + 200, SIDE + 240, 1))
        whole[90 : 90 + SIDE, 130 : 130 + SIDE] = picture
        picture = whole
    pixels = (255 * np.clip(picture, 0, 1)).astype(np.uint8)
    return cv2.imdecode(cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, 75])[1], cv2.IMREAD_COLOR)


def points_of(sketch):
    """Points every pixel or so, in a common place and size."""
    lines = [stroke.points for stroke in sketch.strokes]
    dense = [np.linspace(a, b, 8) for line in lines for a, b in zip(line[:-1], line[1:], strict=True)]
    points = np.concatenate(dense)
    return 200 * (points - points.min(0)) / np.ptp(points, axis=0).max()


PAPERS = {
    "ink": {},
    "pencil": {"darkness": 0.4, "width": 2.0},
    "table": {"table": 0.2},
    "lamp": {"table": 0.1, "fall": 0.6},
    "pen": {"width": 6.0},
}


def ruled(picture, directions, spacing, colour=(0.7, 0.78, 0.95)):
    """A picture on paper with lines in directions, degrees, at a spacing in pixels."""
    lines = np.ones_like(picture, np.float64)
    reach = np.array(picture.shape[:2]).max() * 2
    for angle in np.radians(directions):
        way, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        for step in np.arange(-reach, reach, spacing):
            ends = [tuple(np.round(16 * (step * across + side * reach * way)).astype(int).tolist()) for side in (-1, 1)]
            cv2.line(lines, *ends, colour, 1, cv2.LINE_AA, 4)
    return (picture * lines).astype(np.uint8)


@pytest.mark.parametrize("directions", [(0,), (3,), (90,), (-5, 85)], ids=["lined", "aslant", "on its side", "squared"])
def test_the_lines_of_ruled_paper_are_no_lines_of_the_drawing(sketch, directions):
    picture = photograph(sketch, np.random.default_rng(1), darkness=0.8)
    cleaned = clean_drawing(ruled(picture, directions, 24))
    assert (KDTree(points_of(cleaned)).query(points_of(sketch))[0] < 3).mean() > 0.9
    assert (KDTree(points_of(sketch)).query(points_of(cleaned))[0] < 3).mean() > 0.95


@pytest.mark.parametrize("options", PAPERS.values(), ids=PAPERS.keys())
def test_lines_come_back(sketch, options):
    cleaned = clean_drawing(photograph(sketch, np.random.default_rng(1), **options))
    drawn = points_of(sketch)
    read = points_of(cleaned)
    assert (KDTree(read).query(drawn)[0] < 3).mean() > 0.93
    assert (KDTree(drawn).query(read)[0] < 3).mean() > 0.98
    assert cleaned.size == (256, 256)
    assert {stroke.kind for stroke in cleaned.strokes} == {StrokeKind.UNKNOWN}
    picture = rasterise_sketch(cleaned, 256) > 127
    assert picture.shape == (256, 256) and picture.dtype == bool and 0.01 < picture.mean() < 0.2


def shaded(picture, softness, share=0.5):
    """A picture with the shadow of a phone over a corner of the drawing. softness: pixels of its border."""
    mask = np.zeros(picture.shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, np.array([[-50, -50], [520, -50], [380, 420], [-50, 300]]), 255)
    shadow = cv2.GaussianBlur(mask / 255, (0, 0), softness)[..., None]
    return (picture * (1 - share * shadow)).astype(np.uint8)


def folded(picture):
    """A picture of paper that was folded: one side of it is darker, and the fold is worn."""
    y, x = np.mgrid[:SIDE, :SIDE]
    away = 0.8 * (x - 300) + 0.6 * (y - 300)
    light = (1 - 0.06 * np.tanh(away / 6)) * (1 - 0.12 * np.exp(-((away / 1.5) ** 2)))
    return np.clip(picture * light[..., None], 0, 255).astype(np.uint8)


def smudged(picture, generator):
    """A picture of paper over which a hand has rubbed graphite."""
    mask = np.zeros(picture.shape[:2])
    for middle in generator.integers(150, 550, (6, 2)).tolist():
        cv2.ellipse(mask, middle, (70, 25), generator.uniform(0, 180), 0, 360, 0.15, -1)
    return (picture * (1 - cv2.GaussianBlur(mask, (0, 0), 12))[..., None]).astype(np.uint8)


def on_a_narrow_table(picture):
    """A picture whose paper nearly fills it: a strip of a dark table is left at two sides."""
    table = np.full_like(picture, 60)
    table[14:, :-17] = picture[14:, :-17]
    return table


SPOILT = {
    "hard shadow": partial(shaded, softness=1.5),
    "soft shadow": partial(shaded, softness=25),
    "fold": folded,
    "smudges": lambda picture: smudged(picture, np.random.default_rng(3)),
    "strips of a table": on_a_narrow_table,
}


@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT.keys())
def test_what_lies_over_and_beside_the_paper_is_no_line(sketch, spoil):
    cleaned = clean_drawing(spoil(photograph(sketch, np.random.default_rng(1), fall=0.1)))
    drawn, read = points_of(sketch), points_of(cleaned)
    assert (KDTree(read).query(drawn)[0] < 3).mean() > 0.95
    assert (KDTree(drawn).query(read)[0] < 3).mean() > 0.98


def test_what_is_filled_with_ink_is_its_outline(sketch):
    """A black mouth, as laughs are drawn; black pupils leave no scraps in which lids would be looked for."""
    zoom = SIDE / 256
    lips = np.concatenate([s.points for s in sketch.strokes if s.curve in ("mouth_upper", "mouth_lower")])
    middle, size = lips.mean(0), np.ptp(lips, axis=0).max() / 2
    turns = np.linspace(0, 2 * np.pi, 60)[:, None]
    mouth = middle + size * np.hstack([np.cos(turns), 0.6 * np.sin(turns)])
    rest = sketch.with_strokes(s for s in sketch.strokes if not s.curve.startswith("mouth"))
    picture = photograph(rest, np.random.default_rng(1), darkness=0.85, fall=0.1)
    cv2.fillPoly(picture, [np.round(mouth * zoom).astype(int)], (25, 28, 30))
    for side in ("left", "right"):
        lids = np.concatenate([s.points for s in sketch.strokes if s.curve == f"eye_upper_{side}"])
        cv2.circle(picture, np.round(lids.mean(0) * zoom + [0, 6]).astype(int).tolist(), 9, (30, 30, 30), -1)
    cleaned = clean_drawing(cv2.GaussianBlur(picture, (0, 0), 0.8))
    drawn = points_of(rest.with_strokes([*rest.strokes, rest.strokes[0].moved(mouth)]))
    read = points_of(cleaned)
    assert (KDTree(read).query(drawn)[0] < 3).mean() > 0.93
    assert (KDTree(drawn).query(read)[0] < 3).mean() > 0.95


def test_lines_that_were_searched_for_are_one_each(sketch):
    """Every line three times, some pixels apart: hardly more strokes than of the same drawn once."""
    thrice = sketch.with_strokes(
        stroke.moved((stroke.points - 128) * zoom + 128) for stroke in sketch.strokes for zoom in (0.98, 1, 1.02)
    )
    once, searched = (
        clean_drawing(photograph(each, np.random.default_rng(1), darkness=0.7, width=1.5)) for each in (sketch, thrice)
    )
    lengths = [sum(stroke.length for stroke in each.strokes) for each in (once, searched)]
    assert lengths[1] < 1.2 * lengths[0] and len(searched.strokes) < 1.3 * len(once.strokes)
    assert (KDTree(points_of(searched)).query(points_of(sketch))[0] < 4).mean() > 0.9


def test_a_line_between_two_pale_ones_is_no_shadow(sketch):
    """The middle of two strokes of an outline lies on paper; it had been left out as too pale, and the head with it."""
    outline = next(stroke for stroke in sketch.strokes if stroke.curve == "silhouette")
    ring = outline.moved((outline.points - 128) * 0.96 + 128)
    picture = photograph(sketch.with_strokes([*sketch.strokes, ring]), np.random.default_rng(1), darkness=0.5)
    assert (KDTree(points_of(clean_drawing(picture))).query(points_of(sketch))[0] < 6).mean() > 0.9


@pytest.mark.parametrize("fill", [0.2, 0.12])
def test_a_small_drawing_on_a_large_page_is_read_as_one_that_fills_it(sketch, fill):
    """Its lids and lips lie as near to each other as strokes of a line that was searched for."""
    near = sketch.with_strokes(stroke.moved(128 + fill * (stroke.points - 128)) for stroke in sketch.strokes)
    read = []
    for drawing in (sketch, near):
        page = 255 - rasterise_sketch(drawing, 1600, 2.0)
        read.append(clean_drawing(np.repeat(page[..., None], 3, axis=2).astype(np.uint8)))
    large, small = (np.concatenate([stroke.points for stroke in each.strokes]) for each in read)
    assert len(read[1].strokes) >= 0.8 * len(read[0].strokes)
    assert np.percentile(KDTree(small).query(large)[0], 95) < 3


def test_chalk_on_a_blackboard(sketch):
    board = 255 - photograph(sketch, np.random.default_rng(2))
    assert (KDTree(points_of(clean_drawing(board))).query(points_of(sketch))[0] < 3).mean() > 0.9


def colours(generator):
    """A picture of things in many colours, as a photograph."""
    picture = np.full((SIDE, SIDE, 3), generator.integers(60, 220, 3), np.uint8)
    for _ in range(40):
        middle, axes = generator.integers(0, SIDE, 2), generator.integers(SIDE // 30, SIDE // 5, 2)
        colour = generator.integers(0, 256, 3)
        cv2.ellipse(picture, middle.tolist(), axes.tolist(), generator.uniform(0, 180), 0, 360, colour.tolist(), -1)
    return cv2.GaussianBlur(picture, (0, 0), 1.5)


@pytest.mark.parametrize("seed", range(3))
def test_photographs_are_refused(seed):
    with pytest.raises(InputError, match="lines on paper, found (areas|a picture of many colours)"):
        clean_drawing(colours(np.random.default_rng(seed)))


@pytest.mark.parametrize("name", ["astronaut", "camera", "coffee", "gravel"])
def test_well_known_photographs_are_refused(name):
    picture = read_image(Path(skimage.__file__).parent / "data" / f"{name}.png")
    with pytest.raises(InputError, match="expected a drawing of lines on paper"):
        clean_drawing(picture)


def test_pages_without_lines_are_refused():
    generator = np.random.default_rng(3)
    white = np.full((300, 300, 3), 255, np.uint8)
    dot = white.copy()
    cv2.circle(dot, (150, 150), 2, (0, 0, 0), -1)
    grain = np.clip(200 + generator.normal(0, 5, (300, 300, 1)), 0, 255).astype(np.uint8).repeat(3, axis=2)
    for page in (white, np.zeros_like(white), dot, grain, white[:1, :1]):
        with pytest.raises(InputError, match="expected a drawing of lines on paper"):
            clean_drawing(page)


def close_up(sketch, narrow=1.0, width=4.0, margin=0):
    """A drawing (H, W, 3) that fills its paper, with a margin around it, pixels. narrow: what is left of its width."""
    ink = rasterise_sketch(sketch.with_strokes(s.moved(s.points * [narrow, 1]) for s in sketch.strokes), 512, width)
    rows, columns = (np.flatnonzero(ink.any(axis)) for axis in (1, 0))
    ink = np.pad(ink[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1], 12 + margin)
    return np.repeat(255 - ink[..., None], 3, axis=2)


@pytest.mark.parametrize("margin", [30, 100, 250, 700])
def test_a_margin_around_a_drawing_changes_nothing(sketch, margin):
    """Lids and lips near to each other on a large sheet were taken for lines that were searched for."""
    cropped, wide = (clean_drawing(close_up(sketch, margin=each)) for each in (0, margin))
    assert len(wide.strokes) == len(cropped.strokes)
    for a, b in ((wide, cropped), (cropped, wide)):
        assert np.percentile(KDTree(points_of(a)).query(points_of(b))[0], 99) < 1


@pytest.mark.parametrize("narrow", [0.5, 0.6])
def test_strokes_of_a_narrow_drawing_are_no_ruled_paper(sketch, narrow):
    """Straight lines through many strokes go in all directions; those of ruled paper in one, as far from each other."""
    assert len(clean_drawing(close_up(sketch, narrow, width=6.0)).strokes) > 10


def test_a_mirrored_drawing_has_the_mirror_images_of_the_strokes(sketch):
    picture = close_up(sketch, narrow=0.6)
    once, mirrored = (clean_drawing(each) for each in (picture, np.ascontiguousarray(picture[:, ::-1])))
    assert len(once.strokes) == len(mirrored.strokes)
    for a, b in zip(once.strokes, mirrored.strokes, strict=True):
        assert np.abs(a.points - (np.array([255, 0]) + [-1, 1] * b.points)).max() < 1e-6
