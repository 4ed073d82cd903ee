import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.image import read_image, write_png
from caricli.io.sketches.sketch import write_sketch
from caricli.store.sketches import load_sketch, write_drawing
from caricli.structures import Sketch, Stroke, StrokeKind

ANGLES = np.linspace(0, 2 * np.pi, 80)
RING = 127.5 + 80 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])


@pytest.mark.parametrize("name", ["s.json", "s.svg", "s.png"])
def test_a_sketch_in_any_form(tmp_path, name):
    write_drawing(tmp_path / name, Sketch((Stroke(RING, StrokeKind.SILHOUETTE),)))
    (stroke,) = load_sketch(tmp_path / name).strokes
    middle = stroke.points[:-1].mean(0)
    radius = np.linalg.norm(stroke.points - middle, axis=1)
    assert stroke.closed and radius.std() < 0.02 * radius.mean()
    assert np.allclose(middle, 127.5, atol=1.5)


@pytest.mark.parametrize("ink", [0, 120, 255])
def test_ink_of_any_brightness_on_a_transparent_page(tmp_path, ink):
    write_drawing(tmp_path / "s.png", Sketch((Stroke(RING),)))
    alpha = 255 - read_image(tmp_path / "s.png")[..., :1]
    write_png(tmp_path / "clear.png", np.concatenate([np.full((256, 256, 3), ink, np.uint8), alpha], axis=2))
    (stroke,) = load_sketch(tmp_path / "clear.png").strokes
    assert stroke.closed and np.allclose(stroke.points[:-1].mean(0), 127.5, atol=1.5)


def test_white_paper_with_clear_corners_stays_white(tmp_path):
    write_drawing(tmp_path / "s.png", Sketch((Stroke(RING),)))
    alpha = np.full((256, 256, 1), 255, np.uint8)
    alpha[:20, :20] = 0
    write_png(tmp_path / "clear.png", np.concatenate([read_image(tmp_path / "s.png"), alpha], axis=2))
    assert len(load_sketch(tmp_path / "clear.png").strokes) == 1
    assert (read_image(tmp_path / "clear.png", any_ink=True)[:20, :20] == 255).all()


@pytest.mark.parametrize("name", ["s.json", "s.svg", "s.png"])
def test_a_frame_around_the_drawing_is_no_line_of_it(tmp_path, name):
    frame = np.array([[4.0, 4], [250, 4], [250, 250], [4, 250], [4, 4]])
    eyes = [[x, 110] + 0.1 * (RING - 127.5) for x in (100, 155)]
    write_drawing(tmp_path / name, Sketch(tuple(map(Stroke, (frame, RING, *eyes)))))
    assert len(load_sketch(tmp_path / name).strokes) == 3
    write_drawing(tmp_path / name, Sketch((Stroke(frame, curve="silhouette"), *map(Stroke, (RING, *eyes)))))
    assert len(load_sketch(tmp_path / name).strokes) == (3 if name == "s.png" else 4)


def test_pictures_are_black_on_white(tmp_path):
    write_drawing(tmp_path / "s.png", Sketch((Stroke(RING),)))
    picture = read_image(tmp_path / "s.png")
    assert picture.shape == (256, 256, 3) and picture[0, 0].tolist() == [255] * 3 and picture.min() < 60


@pytest.mark.parametrize(
    ("sketch", "message"),
    [
        (Sketch(), "found 0 strokes"),
        (Sketch((Stroke(RING[:1]),)), "found 1 strokes, 0 pixels long"),
        (Sketch((Stroke(RING + 1000),)), "found 0 % of them there"),
    ],
    ids=["empty", "dot", "outside"],
)
@pytest.mark.parametrize("suffix", [".json", ".svg"])
def test_what_draws_no_face_is_refused(tmp_path, sketch, message, suffix):
    path = tmp_path / f"s{suffix}"
    write_sketch(path, sketch)
    with pytest.raises(InputError, match=message) as refusal:
        load_sketch(path)
    assert str(path) in str(refusal.value)


@pytest.mark.parametrize("name", ["s.json", "s.svg"])
def test_a_curve_may_be_drawn_in_two_strokes(tmp_path, name):
    halves = (Stroke(RING[:40], StrokeKind.SILHOUETTE, "silhouette"), Stroke(RING[39:], curve="silhouette"))
    write_sketch(tmp_path / name, Sketch(halves))
    assert [stroke.curve for stroke in load_sketch(tmp_path / name).strokes] == ["silhouette"] * 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<svg><path d='M1 1'", "expected an SVG of lines, found unclosed token"),
        ("{}", "expected an SVG of lines, found not well-formed"),
        ("<html></html>", "expected an SVG of lines, found <html>"),
    ],
)
def test_a_damaged_svg_is_told_as_one(tmp_path, text, message):
    (tmp_path / "s.svg").write_text(text)
    with pytest.raises(InputError, match=message):
        load_sketch(tmp_path / "s.svg")


def test_black_and_coloured_pictures_are_refused(tmp_path):
    black = np.zeros((64, 64, 3), np.uint8)
    write_png(tmp_path / "s.png", black)
    with pytest.raises(InputError, match="expected a drawing of lines on paper"):
        load_sketch(tmp_path / "s.png")
