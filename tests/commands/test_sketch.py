import numpy as np
import pytest

from caricli.io.face import write_face
from caricli.io.image import read_image
from caricli.io.sketches.sketch import read_sketch
from caricli.structures import Face, Mesh, StrokeKind
from caricli.structures.sketch import CURVES
from tests.named_lines import points_by_curve


@pytest.fixture(scope="module")
def face(head, head_template, tmp_path_factory):
    path = tmp_path_factory.mktemp("face") / "face.npz"
    write_face(path, Face(Mesh(head.evaluate(gender=0.3, age=0.8), head_template.polygons)))
    return path


@pytest.fixture(scope="module")
def front(run, face, tmp_path_factory):
    out = tmp_path_factory.mktemp("front") / "s.json"
    result = run("sketch", face, "--out", out)
    assert result.exit_code == 0 and "strokes" in result.output, result.output
    return read_sketch(out)


def test_all_curves_are_drawn_from_the_front_and_wrinkles_between_them(front):
    assert points_by_curve(front).keys() == CURVES.keys()
    assert front.size == (256, 256)
    wrinkles = [stroke for stroke in front.strokes if stroke.kind is StrokeKind.WRINKLE and stroke.curve is None]
    assert 2 < len(wrinkles) <= 40
    silhouette = points_by_curve(front)["silhouette"]
    for stroke in wrinkles:
        inside = (stroke.points > silhouette.min(0)) & (stroke.points < silhouette.max(0))
        assert inside.all()


def test_svg_and_png_show_the_same(run, face, front, tmp_path):
    for name in ("s.svg", "s.png"):
        assert run("sketch", face, "--out", tmp_path / name).exit_code == 0
    back = read_sketch(tmp_path / "s.svg")
    assert [(s.kind, s.curve) for s in back.strokes] == [(s.kind, s.curve) for s in front.strokes]
    assert all(np.allclose(a.points, b.points, atol=1e-3) for a, b in zip(back.strokes, front.strokes, strict=True))
    ink = read_image(tmp_path / "s.png")[..., 0] < 128
    x, y = np.round(points_by_curve(front)["nose"][1:-1]).astype(int).T
    assert ink.shape == (256, 256) and ink[y, x].mean() > 0.9 and ink.mean() < 0.2


def test_from_aside_hidden_lines_are_left_out(run, face, front, tmp_path):
    result = run("sketch", face, "--out", tmp_path / "s.json", "--view", "-75,0", "--size", 128, "--no-wrinkles")
    assert result.exit_code == 0, result.output
    side = read_sketch(tmp_path / "s.json")
    named = points_by_curve(side)
    # It looks to the left of the picture, so its left ear is seen.
    assert "ear_left" in named and "ear_right" not in named and "silhouette" not in named
    outline = [stroke for stroke in side.strokes if stroke.kind == StrokeKind.SILHOUETTE]
    assert len(outline) == 1 and outline[0].closed and outline[0].length > 250
    assert ((outline[0].points > 0) & (outline[0].points < 128)).all()
    assert {stroke.curve for stroke in side.strokes if stroke.kind == StrokeKind.WRINKLE} <= {*CURVES, None}
    assert run("sketch", face, "--out", tmp_path / "w.json", "--view", "-75,0", "--size", 128).exit_code == 0
    assert len(read_sketch(tmp_path / "w.json").strokes) > len(side.strokes)


@pytest.mark.parametrize("view", ["1", "a,b", "100,0", "0,nan", "1,2,3"])
def test_views_that_are_none_are_wrong_usage(run, face, tmp_path, view):
    result = run("sketch", face, "--out", tmp_path / "s.svg", "--view", view)
    assert result.exit_code == 2 and not (tmp_path / "s.svg").exists()


def test_other_names_and_files_are_refused(run, refused, face, tmp_path):
    assert ".svg or .json or .png" in refused("sketch", face, "--out", tmp_path / "s.txt", code=2)
    (tmp_path / "no.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert "topology" in refused("sketch", tmp_path / "no.obj", "--out", tmp_path / "s.svg")
