import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.lines.line_distances import line_distances
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.subdivide import subdivide
from caricli.methods.gesture.follow_line import _outlines, follow_line, outline_targets
from caricli.methods.gesture.selection import Selection, mark_handles, select_region
from caricli.methods.gesture.settings import GestureSettings
from caricli.methods.gesture.sight import SeenStroke, Sight
from caricli.structures import Camera, Face, Mesh
from tests.methods.gesture.conftest import mark, ring, view

BROW = range(17, 22)


@pytest.fixture(scope="module")
def brow(face, head_template):
    camera = view()
    line = np.stack([mark(face, head_template, camera, number) for number in BROW])
    return camera, line, mark_handles(face, camera, line, 5, Selection())


def test_a_curve_of_handles_is_laid_onto_the_line(face, head_template, brow):
    camera, line, selection = brow
    goal = line + [[0, -12], [0, -10], [0, -8], [0, -6], [0, -4]]
    changed = follow_line(face, head_template, SeenStroke(goal, camera), selection)
    ids = head_template.annotation.landmarks[17:22]
    before, after = (line_distances(camera.project(each.vertices[ids]), [goal]) for each in (face, changed.face))
    assert changed.share == 1 and after.mean() < 0.35 * before.mean()
    depths = [(each.vertices @ camera.rotation[2])[selection.handles] for each in (face, changed.face)]
    np.testing.assert_allclose(*depths, atol=1e-9)
    gradients = head_template.gradients
    turned = [flipped_triangles(each.vertices, gradients) for each in (face, changed.face)]
    assert not (turned[1] & ~turned[0]).any()


def test_the_direction_of_the_line_does_not_matter_to_a_curve(face, head_template, brow):
    camera, line, selection = brow
    goal = line - [0, 8]
    there, back = (follow_line(face, head_template, SeenStroke(each, camera), selection) for each in (goal, goal[::-1]))
    np.testing.assert_allclose(there.face.vertices, back.face.vertices, atol=1e-12)


def test_a_patch_goes_as_the_line_does(face, head_template):
    camera = view(90)
    tip = mark(face, head_template, camera, 30)
    selection = mark_handles(face, camera, tip[None], 12, Selection())
    changed = follow_line(face, head_template, SeenStroke(np.stack([tip, tip + [10, 4]]), camera), selection)
    moved = camera.project(changed.face.vertices) - camera.project(face.vertices)
    np.testing.assert_allclose(moved[selection.handles] / changed.share, [[10, 4]] * len(selection.handles), atol=1e-6)


def test_outside_the_region_nothing_changes_by_a_bit(face, head_template, brow):
    camera, line, selection = brow
    selection = select_region(face, camera, ring(line.mean(0), 45, 0.6), selection)
    changed = follow_line(face, head_template, SeenStroke(line - [0, 6], camera), selection)
    outside = np.ones(len(face.vertices), bool)
    outside[selection.region] = False
    for name in ("inner_mouth", "eye_socket_left", "eye_socket_right"):
        outside[head_template.annotation.regions[name]] = False
    assert np.array_equal(changed.face.vertices[outside], face.vertices[outside])


def test_symmetric_is_the_same_on_both_sides(face, head_template, brow):
    camera, line, selection = brow
    changed = follow_line(face, head_template, SeenStroke(line - [0, 6], camera), selection, symmetric=True)
    moved = changed.face.vertices - face.vertices
    np.testing.assert_allclose(moved[head_template.annotation.mirror] * [-1, 1, 1], moved, atol=2e-4)


def test_without_handles_the_outline_goes_to_the_line(face, head_template):
    camera = view(90)
    profile = np.stack([mark(face, head_template, camera, number) for number in range(27, 34)])
    goal = profile + np.array([0, 3, 6, 9, 8, 3, 0])[:, None] * [1, 0]
    changed = follow_line(face, head_template, SeenStroke(goal, camera), Selection())
    ids = head_template.annotation.landmarks[28:32]
    before, after = (line_distances(camera.project(each.vertices[ids]), [goal]) for each in (face, changed.face))
    assert after.mean() < 0.4 * before.mean()


@pytest.fixture(scope="module")
def round_face(ball):
    """Face that is a unit sphere."""
    weights, quads = subdivide(ball[1], len(ball[0]), 2, 10_000)
    points = weights @ ball[0]
    return Face(Mesh(points / np.linalg.norm(points, axis=1, keepdims=True), quads))


FRONT = Camera(100.0, np.diag([1.0, -1, -1]), np.zeros(2))


def arc(degrees):
    """(20, 2) pixels of a line beside the outline of a unit sphere that FRONT sees."""
    turns = np.radians(degrees + np.linspace(-60, 60, 20))
    return 105 * np.stack([np.cos(turns), np.sin(turns)], axis=1)


@pytest.mark.parametrize("degrees", range(0, 360, 45))
def test_an_outline_that_is_a_whole_ring_is_met_wherever_it_begins(round_face, degrees):
    line = arc(degrees)
    ids, _ = outline_targets(round_face, FRONT, line, Selection(), GestureSettings())
    assert line_distances(FRONT.project(round_face.vertices[ids]), [line]).max() < 30


@pytest.mark.parametrize("order", [1, -1])
def test_an_outline_goes_on_behind_what_hides_it_shortly_wherever_its_ring_begins(round_face, order):
    """A small triangle is before the right end of a sphere, whose vertices there are the first or the last ones."""
    vertices = round_face.vertices
    first = np.argsort(order * np.linalg.norm(vertices - [1, 0, 0], axis=1))
    faces = np.argsort(first)[round_face.faces]
    small = np.array([1.0, 0, 2]) + 0.04 * np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]])
    mesh = Mesh(np.vstack([vertices[first], small]), np.vstack([faces, len(vertices) + np.arange(3)]))
    line = arc(0)
    ids, _ = outline_targets(Face(mesh), FRONT, line, Selection(), GestureSettings())
    assert line_distances(line, [FRONT.project(mesh.vertices[ids])]).max() < 10


def test_a_whole_ring_is_cut_in_one_place_however_vertices_are_numbered(round_face):
    vertices = round_face.vertices
    lines = []
    for seed in range(4):
        first = np.random.default_rng(seed).permutation(len(vertices))
        sight = Sight(Mesh(vertices[first], np.argsort(first)[round_face.faces]), FRONT)
        parts = _outlines(sight, np.ones(len(vertices), bool), arc(0))
        points = max((points for _, points in parts), key=len)
        lines.append(points if points[0, 1] < points[-1, 1] else points[::-1])
    for points in lines[1:]:
        np.testing.assert_allclose(points, lines[0], atol=1e-6)


def test_what_no_line_can_mean_is_refused(face, head_template, brow):
    camera, line, selection = brow
    with pytest.raises(InputError, match="found a dot"):
        follow_line(face, head_template, SeenStroke(np.array([[1.0, 1], [1.1, 1]]), camera), selection)
    with pytest.raises(InputError, match="no outline there"):
        follow_line(face, head_template, SeenStroke(line - [900, 0], camera), Selection())
    elsewhere = select_region(face, camera, ring(mark(face, head_template, camera, 8), 20), selection)
    with pytest.raises(InputError, match="all of them outside"):
        follow_line(face, head_template, SeenStroke(line, camera), elsewhere)
