import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.sketches.sketch import read_sketch, write_sketch
from caricli.structures import Sketch, Stroke, StrokeKind

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '


def read(folder, body, head='viewBox="0 0 300 400"', start=""):
    path = folder / "s.svg"
    path.write_text(f"{start}{HEAD}{head}>{body}</svg>", "utf-8")
    return read_sketch(path)


def points(folder, body, **options):
    """The points in the units of the drawing, whose corner is the origin."""
    (stroke,) = read(folder, body, **options).strokes
    return stroke.points + 0.5


def test_what_is_written_comes_back(tmp_path):
    strokes = (
        Stroke(np.array([[1.25, 2], [3, 4], [1.25, 2]]), StrokeKind.FEATURE, "nose", np.array([0, 0.5, 1]), 2.5),
        Stroke(np.array([[7.0, 200]]), StrokeKind.WRINKLE),
        Stroke(np.array([[1.0, 2], [-3, 4.125]]), StrokeKind.SILHOUETTE, 'my "own" <curve>'),
        Stroke(np.array([[1.0, 2], [3, 4]])),
    )
    write_sketch(tmp_path / "s.svg", Sketch(strokes, (300, 256)))
    back = read_sketch(tmp_path / "s.svg")
    assert back.size == (300, 256)
    for stroke, other in zip(strokes, back.strokes, strict=True):
        assert np.allclose(stroke.points, other.points, atol=1e-4)
        assert (stroke.kind, stroke.curve) == (other.kind, other.curve)
    assert back.strokes[0].pressure.tolist() == [0, 0.5, 1] and back.strokes[0].width == 2.5


def test_every_command_of_a_path(tmp_path):
    line = points(tmp_path, '<path d="M10 20 h5 v6 l1,1 L 30 40 H 2 V 3 z"/>')
    assert np.allclose(line, [[10, 20], [15, 20], [15, 26], [16, 27], [30, 40], [2, 40], [2, 3], [10, 20]])
    curve = points(tmp_path, '<path d="M0 0 C 0 100 200 100 200 0 S 300 200 200 100"/>')
    # The middle of a Bezier curve is an eighth of its ends and three eighths of its controls.
    assert np.abs(curve - [100, 75]).sum(1).min() < 2 and np.allclose(curve[-1], [200, 100])
    parabola = points(tmp_path, '<path d="M0 0 Q 50 100 100 0 T 200 0"/>')
    first = parabola[parabola[:, 0] <= 100]
    assert np.allclose(first[:, 1], first[:, 0] * (100 - first[:, 0]) / 50, atol=1e-6)
    assert np.isclose(parabola[:, 1].min(), -50, atol=0.2)
    arc = points(tmp_path, '<path d="M 100 50 A 50 50 0 0 1 50 100"/>')
    assert np.allclose(np.linalg.norm(arc - 50, axis=1), 50)


def test_parts_of_a_path_are_strokes(tmp_path):
    sketch = read(tmp_path, '<path class="wrinkle" d="M9 9 M1 2 L3 4 M5 6 L7 8 m1 1 l2 2 M9 9"/>')
    assert [len(stroke.points) for stroke in sketch.strokes] == [2, 2, 2]
    assert {stroke.kind for stroke in sketch.strokes} == {StrokeKind.WRINKLE}


def test_transforms_of_groups_are_composed(tmp_path):
    body = (
        '<g transform="translate(10 20)"><g transform="rotate(90)"><line x2="5" y2="0" transform="scale(2)"/></g></g>'
    )
    assert np.allclose(points(tmp_path, body), [[10, 20], [10, 30]])
    used = '<defs><line id="a" x2="5"/></defs><use xlink:href="#a" x="100" y="7" transform="scale(2 3)"/>'
    assert np.allclose(points(tmp_path, used), [[200, 21], [210, 21]])


def test_a_view_box_is_the_canvas(tmp_path):
    sketch = read(tmp_path, '<line x1="10" y1="20" x2="20" y2="40"/>', head='viewBox="10 20 10 20" width="3mm"')
    assert sketch.size == (128, 256)
    assert np.allclose(sketch.strokes[0].points + 0.5, [[0, 0], [128, 256]])
    inches = read(tmp_path, '<line x2="96" y2="96"/>', head='width="4in" height="4in"')
    assert inches.size == (384, 384)
    nothing = read(tmp_path, '<line x1="1000" x2="1001" y2="1"/>', head="")
    assert nothing.size == (256, 256) and (nothing.strokes[0].points > 0).all()


def test_names_say_what_is_drawn(tmp_path):
    body = (
        '<g id="Features"><g class="feature"><path id="nose_bridge" d="M1 1 L2 2"/><path d="M1 1 L2 2"/></g></g>'
        '<g id="wrinkle-2"><path d="M1 1 L2 2"/></g><path id="brow-left" d="M1 1 L2 2"/><path id="x" d="M1 1 L2 2"/>'
        '<path id="silhouette" d="M1 1 L2 2"/><path data-name="mouth_x5F_upper" d="M1 1 L2 2"/>'
    )
    drawn = [(str(stroke.kind), stroke.curve) for stroke in read(tmp_path, body).strokes]
    assert drawn == [
        ("feature", "nose_bridge"), ("feature", None), ("wrinkle", None), ("feature", "brow_left"), ("unknown", None),
        ("silhouette", "silhouette"), ("wrinkle", "mouth_upper"),
    ]  # fmt: skip


def test_a_layer_of_all_lines_of_a_nose_says_no_curve(tmp_path):
    path = '<path d="M1 1 L2 2"/>'
    for layer, curve in ((path, "nose"), (2 * path, None), (f"<g>{path}</g>{path}", None)):
        drawn = [(str(stroke.kind), stroke.curve) for stroke in read(tmp_path, f'<g id="Nose">{layer}</g>').strokes]
        assert set(drawn) == {("feature", curve)}


def test_backgrounds_and_what_is_hidden_are_left_out(tmp_path):
    body = (
        "<style>.b { fill:none; stroke: #000; stroke-width: 3px } .c{display:none}</style>"
        '<rect width="300" height="400" fill="white"/><path class="b" d="M1 1 L2 2"/>'
        '<g style="display:none"><line stroke="red" x2="4"/></g><line class="c" stroke="red" x2="4"/>'
    )
    (stroke,) = read(tmp_path, body).strokes
    assert len(stroke.points) == 2 and stroke.width == 3


def test_a_style_sheet_of_any_length_is_read(tmp_path):
    filling = 400_000 * "a"
    sheet = f"@media print {{ p, {1000 * '.p, '}.b {{ {1000 * 'fill: none; '}stroke-width: 3px }} }} {filling}"
    (stroke,) = read(tmp_path, f'<style>{sheet}</style><path class="b" d="M1 1 L2 2"/>').strokes
    assert stroke.width == 3


@pytest.mark.parametrize("selector", ["path", "g > *", "g > path", "#b", "path.b", "svg .b"])
def test_a_style_sheet_speaks_of_elements_ids_and_classes(tmp_path, selector):
    others = "rect{fill:#fff;stroke:none} path:hover{stroke:none}"
    sheet = f"<style>{selector}{{fill:none;stroke:#222;stroke-width:3px}} {others}</style>"
    body = '<rect width="300" height="400"/><g><path id="b" class="b" d="M1 1 L2 2"/></g>'
    (stroke,) = read(tmp_path, sheet + body).strokes
    assert len(stroke.points) == 2 and stroke.width == 3


def test_style_sheets_add_to_each_other(tmp_path):
    sheets = "<style>.b{fill:none;stroke:#222}</style><style>.b{stroke-width:3px}</style>"
    body = '<rect width="300" height="400"/><path class="b" d="M1 1 L2 2"/>'
    (stroke,) = read(tmp_path, sheets + body).strokes
    assert len(stroke.points) == 2 and stroke.width == 3


@pytest.mark.parametrize("classes", ["a b", "b a"])
def test_of_classes_that_say_the_same_the_last_one_of_the_sheet_counts(tmp_path, classes):
    sheet = ".a{stroke-width:1px;stroke:#222} .b{stroke-width:2px;fill:none;stroke:none} .a{stroke:#444}"
    (stroke,) = read(tmp_path, f'<style>{sheet}</style><path class="{classes}" d="M1 1 L2 2"/>').strokes
    assert stroke.width == 2


@pytest.mark.parametrize(
    ("sheet", "style"),
    [
        (".b{/* thin; } */stroke:none;fill:none}", ""),
        ("", "fill:none;/* stroke:red; */stroke:none"),
        (".b{stroke:none !important;fill:none!important;stroke:red} #b{stroke:red}", "stroke:red;fill:red"),
        (".b{stroke:red !important}", "stroke:none! important;fill:none"),
        ("#b{stroke:none;fill:none} /* .b{stroke:red !important}", ""),
    ],
)
def test_comments_say_nothing_and_what_is_important_counts(tmp_path, sheet, style):
    path = f'<path id="b" class="b" stroke="red" style="{style}" d="M1 1 L2 2"/>'
    (stroke,) = read(tmp_path, f'<style>{sheet}</style>{path}<line stroke="red" x2="4"/>').strokes
    assert stroke.points[-1, 0] == 3.5


def outline(line, widths):
    """The outline of a mark, as a path."""
    ways = np.gradient(line, axis=0)
    across = np.stack([-ways[:, 1], ways[:, 0]], 1) / np.linalg.norm(ways, axis=1, keepdims=True) * widths[:, None] / 2
    return "M " + " ".join(f"{x:.2f},{y:.2f}" for x, y in [*(line + across), *(line - across)[::-1]]) + " z"


T = np.linspace(0, 1, 400)
LINE = np.stack([40 + 200 * T, 200 + 60 * np.sin(6 * T)], 1)
LOOP = np.stack([150 + 80 * np.cos(6.6 * T), 200 + 80 * np.sin(6.6 * T)], 1)
PRESSED = 1 + 4 * np.sin(np.pi * T)


@pytest.mark.parametrize("line", [LINE, LOOP], ids=["wave", "over itself"])
@pytest.mark.parametrize("style", ['fill="#1e1e1e" stroke="none"', 'style="fill:#000"', ""])
def test_marks_of_a_brush_are_the_lines_in_their_middles(tmp_path, line, style):
    body = f'<rect width="300" height="400" fill="white"/><path id="nose" {style} d="{outline(line, PRESSED)}"/>'
    (stroke,) = read(tmp_path, body).strokes
    gaps = np.linalg.norm(stroke.points[:, None] + 0.5 - line, axis=2)
    assert gaps.min(1).max() < 2.5 and np.median(gaps.min(0)) < 2
    assert stroke.curve == "nose" and 2 < stroke.width < 5


@pytest.mark.parametrize("rule", ["evenodd", "nonzero"])
def test_a_ring_that_a_tracer_filled_is_one_line(tmp_path, rule):
    circle = "a{0} {0} 0 1 {1} {2} 0a{0} {0} 0 1 {1} -{2} 0z"
    rings = f"M50 200{circle.format(80, 1, 160)}M53 200{circle.format(77, 0, 154)}"
    (stroke,) = read(tmp_path, f'<path fill="#000" fill-rule="{rule}" d="{rings}"/>').strokes
    assert np.allclose(np.linalg.norm(stroke.points + 0.5 - [130, 200], axis=1), 78.5, atol=0.7)
    assert stroke.closed and np.isclose(stroke.width, 3, atol=0.8)


def test_more_marks_than_a_hand_draws_are_refused(tmp_path):
    mark = '<path d="M0 0 L0.1 0 L300 400 L299.9 400 z"/>'
    with pytest.raises(InputError, match="more than a hand draws"):
        read(tmp_path, 60 * mark)


def test_shapes_are_lines(tmp_path):
    body = (
        '<polygon points="1,2 3,4 5,6"/><rect x="1" y="2" width="3" height="4"/><circle cx="5" cy="6" r="2"/>'
        '<ellipse rx="3" ry="5"/><text>words</text>'
    )
    strokes = read(tmp_path, body).strokes
    assert len(strokes) == 4 and all(stroke.closed for stroke in strokes)
    assert np.allclose(np.ptp(strokes[3].points, axis=0), [6, 10])


def test_percents_are_of_the_drawing_that_a_shape_lies_in(tmp_path):
    def strokes(*shapes):
        body = "".join(f"<{shape} stroke='black' fill='none'/>" for shape in shapes)
        return read(tmp_path, body, "viewBox='0 0 400 300'").strokes

    shares = strokes("line x1='25%' y1='10%' x2='75%' y2='50%'", "circle cx='50%' cy='50%' r='10%'")
    units = strokes("line x1='100' y1='30' x2='300' y2='150'", f"circle cx='200' cy='150' r='{25 * 2**0.5}'")
    for share, unit in zip(shares, units, strict=True):
        assert np.allclose(share.points, unit.points, atol=1e-9)


def test_an_empty_drawing_is_an_empty_sketch(tmp_path):
    assert read(tmp_path, "").strokes == ()


BOMB = '<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>'
FILE = '<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize(
    ("body", "start", "message"),
    [
        ("<script>alert(1)</script>", "", "found a script"),
        ("&b;", BOMB, "found entities.*Illustrator"),
        ('<image href="data:image/png;base64,AA"/>', "", "found a picture alone: give it as PNG"),
        ("&a;", FILE, "found entities"),
        ('<use href="http://example.org/a.svg#b"/>', "", "found a reference to 'http"),
        ('<image xlink:href="../secret.png"/>', "", "nothing outside the file, found a reference to '../secret"),
        ("<g>", "", "expected an SVG of lines, found"),
        ('<path d="M 1 nonsense"/>', "", "expected a path"),
        ('<path d="L 1 1"/>', "", "begins with a move"),
        ('<path d="M 1e999 1 L 2 2"/>', "", "path with finite numbers"),
        ('<line x2="1e8"/>', "", "expected finite coordinates"),
        ('<g transform="matrix(1 2 3)"/>', "", "transform: expected one"),
        ('<g transform="scale(1e400)"/>', "", "transform: expected one"),
        ('<line x2="3" data-pressure="0.5 x"/>', "", "data-pressure: expected numbers"),
        ('<line x2="3" data-pressure="0_1 0.5"/>', "", "data-pressure: expected numbers"),
        ('<line x2="3" data-pressure="0.5 0.5 1"/>', "", "pressure: expected the shape"),
        ('<g id="a"><use href="#a"/><use href="#a"/></g>', "", "elements, 64 deep, found more"),
        ("<g>" * 100 + "</g>" * 100, "", "elements, 64 deep, found more"),
        ("<polyline points='" + "1,2 " * 250_000 + "'/>", "", "at most 200000 points"),
    ],
    ids=lambda value: value[:30],
)
def test_what_is_no_drawing_is_refused(tmp_path, body, start, message):
    with pytest.raises(InputError, match=message) as refusal:
        read(tmp_path, body, start=start)
    assert "\n" not in str(refusal.value) and "s.svg" in str(refusal.value)
    # An ordinary document type is none of these.
    assert (
        read(tmp_path, "<g/>", start='<?xml version="1.0"?><!DOCTYPE svg PUBLIC "-//W3C//DTD" "x.dtd">').strokes == ()
    )


@pytest.mark.parametrize("side", ["1e-310", "1e-300", "9e-10"])
def test_a_drawing_too_small_to_be_drawn_larger_is_refused(tmp_path, side):
    with pytest.raises(
        InputError, match=f"s.svg: viewBox: expected a drawing of at least 1e-09 units, found .* {side}"
    ):
        read(tmp_path, '<line x2="1"/>', head=f'viewBox="0 0 {side} {side}"')
    sketch = read(tmp_path, '<line x2="1e-9"/>', head=f'viewBox="0 0 {side} 1e-9"')
    np.testing.assert_allclose(np.ptp(sketch.strokes[0].points, axis=0), [256, 0])


@pytest.mark.filterwarnings("error")
def test_scales_beyond_all_numbers_say_nothing_but_the_error(tmp_path):
    with pytest.raises(InputError, match="expected finite coordinates"):
        read(tmp_path, '<g transform="scale(1e200)"><line x2="1"/></g>')
    frame = "<svg width='1e9%' viewBox='0 0 1 1e-9' preserveAspectRatio='xMidYMid slice'>"
    with pytest.raises(InputError, match="expected finite coordinates"):
        read(tmp_path, 60 * frame + '<line x2="1"/>' + 60 * "</svg>")


def test_uses_that_multiply_end(tmp_path):
    layers = "".join(f'<g id="a{k + 1}">' + f'<use href="#a{k}"/>' * 10 + "</g>" for k in range(8))
    with pytest.raises(InputError, match="found more"):
        read(tmp_path, f'<line id="a0" x2="1"/>{layers}')


@pytest.mark.parametrize("width", ["384", "384px", "288pt", "24pc", "101.6mm", "10.16cm", "4in"])
def test_units_are_those_of_css(tmp_path, width):
    sketch = read(tmp_path, '<line x2="96" y2="96"/>', head=f'width="{width}" height="{width}"')
    assert sketch.size == (384, 384)


def test_lines_grow_with_their_groups_and_what_is_left_over_is_left_out(tmp_path):
    """Of a polyline the number without a partner, of an arc its radius of nothing, of a symbol what nobody uses."""
    line = '<line x2="9" fill="none" stroke="#000" stroke-width="3"/>'
    (stroke,) = read(tmp_path, f'<g transform="scale(2)">{line}</g>', head='viewBox="0 0 2000 2000"').strokes
    assert stroke.width == pytest.approx(6)
    body = '<polyline points="1,2 3,4 5"/><path d="M0 0 A5 0 0 0 1 10 0"/>'
    assert [len(stroke.points) for stroke in read(tmp_path, body).strokes] == [2, 2]
    symbol = f'<symbol id="s">{line}</symbol>'
    assert [len(read(tmp_path, symbol + used).strokes) for used in ("", '<use href="#s"/>')] == [0, 1]


def test_a_symbol_lies_where_its_use_and_its_view_box_put_it(tmp_path):
    """As Illustrator writes symbols: around their middle, with y up."""
    symbol = '<symbol id="e" viewBox="-60 -40 120 80"><line x1="-60" y1="-40" x2="60" y2="0"/></symbol>'
    use = '<use xlink:href="#e" x="-60" y="-40" width="120" height="80" transform="matrix(-1 0 0 -1 200 100)"/>'
    assert np.allclose(points(tmp_path, symbol + use), [[260, 140], [140, 100]])
    twice = symbol.replace("symbol", "symbol preserveAspectRatio='none'", 1)
    use = '<use href="#e" x="10" y="20" width="240" height="240"/>'
    assert np.allclose(points(tmp_path, twice + use), [[10, 20], [250, 140]])


@pytest.mark.parametrize(
    ("head", "expected"),
    [
        ('x="10" y="20"', [[10, 20], [11, 22]]),
        ('x="10" y="20" width="60" height="40" viewBox="0 0 30 20"', [[10, 20], [12, 24]]),
        ('width="60" height="140" viewBox="0 0 30 20"', [[0, 50], [2, 54]]),
        ('width="60" height="140" viewBox="0 0 30 20" preserveAspectRatio="xMidYMin"', [[0, 0], [2, 4]]),
        ('x="99" width="60" height="80" viewBox="0 0 30 20" preserveAspectRatio="xMaxYMid slice"', [[39, 0], [43, 8]]),
        ('viewBox="0 0 30 20" height="50%"', [[0, 0], [10, 20]]),
        ('viewBox="0 0 0 20" x="1"', [[1, 0], [2, 2]]),
    ],
)
def test_a_drawing_in_a_drawing_lies_where_its_view_box_puts_it(tmp_path, head, expected):
    assert np.allclose(points(tmp_path, f'<svg {head}><line x2="1" y2="2"/></svg>'), expected)


@pytest.mark.parametrize(
    "style",
    [
        'stroke="#f00" opacity="0"', 'stroke="#f00" style="stroke-opacity:0"', 'stroke="#f00" stroke-width="0"',
        'stroke="rgba(255, 0, 0, 0)" fill="none"', 'stroke="#f000" fill="none"',
    ],
)  # fmt: skip
def test_what_cannot_be_seen_is_no_line(tmp_path, style):
    line = '<line stroke="#000" stroke-opacity="1" x2="4"/>'
    (stroke,) = read(tmp_path, f"<g {style}><line x2='9' y2='9'/></g>{line}").strokes
    assert stroke.points[-1, 0] == 3.5


def test_what_is_visible_in_a_hidden_group_is_a_line(tmp_path):
    lines = '<line x2="4"/><line visibility="visible" x2="5"/><g style="visibility:visible"><line x2="6"/></g>'
    hidden = f'<g visibility="hidden" stroke="red">{lines}</g><g visibility="collapse" stroke="red">{lines}</g>'
    drawn = read(tmp_path, hidden + f'<g display="none" stroke="red">{lines}</g>').strokes
    assert [stroke.points[-1, 0] for stroke in drawn] == [4.5, 5.5, 4.5, 5.5]


def test_a_fill_that_cannot_be_seen_is_no_mark_of_a_brush(tmp_path):
    mark = f'<path fill="#000" fill-opacity="0" d="{outline(LINE, PRESSED)}"/>'
    assert len(read(tmp_path, mark + '<line stroke="#000" x2="4"/>').strokes) == 1


def test_a_style_says_a_transform_too(tmp_path):
    moved = '<g transform="scale(9)" style="transform: translate(10px, 20px) scale(-1, 2)"><line x2="5" y2="1"/></g>'
    assert np.allclose(points(tmp_path, moved), [[10, 20], [5, 22]])
    sheet = "<style>.m{transform:rotate(90deg)}</style>"
    assert np.allclose(points(tmp_path, f'{sheet}<g class="m"><line x2="5"/></g>'), [[0, 0], [0, 5]])


LIGHT = '<line stroke="{}" x2="4"/><line stroke="#f00" x2="9"/>'


def ends(folder, body, **options):
    """The first and the last point of every stroke, in units of the drawing."""
    strokes = read(folder, body, **options).strokes
    return [(stroke.points[[0, -1]] + 0.5).round(6).tolist() for stroke in strokes]


@pytest.mark.parametrize("line", ["M-5 10 V300", "M310 10 h50", "M10 -9 L-9 -9", "M50 401 h9"])
def test_what_lies_beside_the_canvas_is_no_line(tmp_path, line):
    body = f'<g stroke="#000" fill="none"><path d="{line}"/><path d="M-5 10 H20"/></g>'
    assert ends(tmp_path, body) == [[[-5, 10], [20, 10]]]
    assert len(read(tmp_path, body, head="").strokes) == 2


@pytest.mark.parametrize(
    ("behind", "paint", "count"),
    [
        ("", "#fff", 1), ("", "#f8f8f8", 1), ("", "#ff0", 2), ("", "#ccc", 2), ("", "url(#gradient)", 2),
        ('<rect width="300" height="400" fill="#222"/>', "#fff", 2),
        ('<path d="M0 0H300V400H0z" fill="#222"/>', "#252525", 1),
        ('<rect width="100%" height="100%" fill="url(#gradient)"/>', "#fff", 2),
        ('<rect width="200" height="400" fill="#222"/>', "#fff", 1),
        ('<rect width="300" height="400" fill="#222" fill-opacity="0"/>', "#fff", 1),
    ],
)  # fmt: skip
def test_strokes_of_the_colour_of_the_paper_are_no_lines(tmp_path, behind, paint, count):
    assert len(read(tmp_path, behind + LIGHT.format(paint)).strokes) == count


def test_a_drawing_of_nothing_but_such_strokes_has_no_lines(tmp_path):
    assert not read(tmp_path, '<path fill="none" stroke="#fff" d="M1 1 L9 9"/>').strokes


def test_a_light_mark_of_a_brush_on_dark_paper_is_its_middle(tmp_path):
    mark = f'<path fill="#fff" d="{outline(LINE, PRESSED)}"/>'
    dark = '<rect width="300" height="400" fill="#222"/>'
    assert [len(read(tmp_path, each + mark + LIGHT.format("#f00")).strokes) for each in ("", dark)] == [2, 3]


ACROSS = '<g stroke="#000" fill="none" clip-path="url(#c)"><path d="M0 50 H100"/><path d="M0 300 H9"/></g>'


@pytest.mark.parametrize(
    ("clip", "parts"),
    [
        ('<rect x="20" y="20" width="60" height="60"/>', [(20, 80)]),
        ('<rect width="200" height="350"/>', [(0, 100), (0, 9)]),
        ('<rect x="20" y="20" width="10" height="60"/><circle cx="60" cy="50" r="10"/>', [(20, 30), (50, 70)]),
        ('<path d="M10 10H90V90H10z M40 40H60V60H40z"/>', [(10, 90)]),
        ('<path clip-rule="evenodd" d="M10 10H90V90H10z M40 40H60V60H40z"/>', [(10, 40), (60, 90)]),
        ('<polygon transform="translate(10)" points="0,0 0,100 50,50"/>', [(10, 60)]),
        ('<use href="#r" x="5"/>', [(15, 25)]),
        ("", []),
    ],
)
def test_lines_are_cut_to_what_clips_them(tmp_path, clip, parts):
    rest = '<defs><rect id="r" x="10" width="10" height="100"/></defs><line stroke="#000" x1="1" x2="2"/>'
    drawn = ends(tmp_path, f'{rest}<clipPath id="c">{clip}</clipPath>{ACROSS}')
    assert [(first[0], last[0]) for first, last in drawn[1:]] == parts


def test_clips_within_others_and_those_of_a_moved_group_cut_together(tmp_path):
    clips = '<clipPath id="c"><rect width="50" height="99"/></clipPath><clipPath id="d"><rect width="9" height="9"/>'
    body = f'{clips}</clipPath><g transform="translate(40)" style="clip-path: url(#d)"><g transform="scale(2 .1)">'
    moved = ACROSS.replace("<g", '<g transform="translate(-5)"')
    assert ends(tmp_path, body + moved + "</g></g>") == [[[40, 5], [49, 5]]]


@pytest.mark.parametrize("told", ['clip-path="none"', 'clip-path="url(#b)"', 'clip-path="inset(9px)"'])
def test_what_clips_in_another_way_is_passed_over(tmp_path, told):
    box = '<clipPath id="b" clipPathUnits="objectBoundingBox"><rect width=".5" height=".5"/></clipPath>'
    assert ends(tmp_path, f'{box}<line {told} x2="9"/>') == [[[0, 0], [9, 0]]]


def test_more_to_clip_than_a_hand_draws_is_refused(tmp_path):
    zigzag = " ".join(f"{k % 7},{k % 5}" for k in range(20_000))
    body = f'<clipPath id="c"><polygon points="{zigzag}"/></clipPath><polyline clip-path="url(#c)" points="{zigzag}"/>'
    with pytest.raises(InputError, match="clip-path: expected fewer or simpler lines"):
        read(tmp_path, body)


@pytest.mark.parametrize(
    ("origin", "end"),
    [
        ("30px 40px", [15, 20]), ("50% 25%", [75, 50]), ("center 10", [75, 5]), ("top right", [150, 0]),
        ("bottom", [75, 200]), ("10", [5, 100]), ("0 0", [0, 0]),
    ],
)  # fmt: skip
def test_a_transform_is_about_its_origin(tmp_path, origin, end):
    line = '<line x1="150" y1="200" x2="0" y2="0" {}/>'
    for told in (f'transform="scale(.5)" transform-origin="{origin}"',
                 f'style="transform: scale(.5); transform-origin: {origin}"'):  # fmt: skip
        assert np.allclose(points(tmp_path, line.format(told))[-1], end)
    assert np.allclose(points(tmp_path, line.format(f'transform-origin="{origin}"'))[-1], 0)


@pytest.mark.parametrize("told", ["transform-origin: near far", "transform-origin: 1em 2em", "transform-box:fill-box"])
def test_an_origin_that_says_nothing_here_is_refused(tmp_path, told):
    with pytest.raises(InputError, match="transform-origin: expected lengths"):
        read(tmp_path, f'<line x2="9" transform="scale(2)" style="{told}"/>')
    assert len(read(tmp_path, f'<line x2="9" style="{told}"/>').strokes) == 1


def test_without_a_size_lines_are_as_fine_and_as_wide_as_with_one(tmp_path):
    body = '<circle cx="5" cy="5" r="4" fill="none" stroke="black" stroke-width="0.1"/>'
    (framed,), (bare,) = (read(tmp_path, body, head=head).strokes for head in ('viewBox="0.6 0.6 8.8 8.8"', ""))
    assert bare.width == pytest.approx(framed.width) == pytest.approx(0.1 * 256 / 8.8)
    assert len(bare.points) == len(framed.points) > 50
    np.testing.assert_allclose(np.ptp(bare.points, axis=0), np.ptp(framed.points, axis=0), rtol=1e-3)


def test_of_two_elements_of_one_name_the_first_is_used(tmp_path):
    twice = '<defs><line id="a" x2="10"/><line id="a" x2="99" y2="99"/></defs><use href="#a"/>'
    np.testing.assert_allclose(points(tmp_path, twice), [[0, 0], [10, 0]])
