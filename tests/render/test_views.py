import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.shade import Look
from caricli.render.views import VIEWS, render_views, turntable
from caricli.structures import Mesh

MIRROR = np.array([-1.0, 1, 1])


def box(picture):
    y, x = np.nonzero(picture[..., 3])
    return x.min(), x.max(), y.min(), y.max()


def mean_difference(a, b):
    return np.abs(a[..., 3].astype(float) - b[..., 3]).mean() / 255


@pytest.mark.parametrize(
    ("view", "twin"), [("front", "front"), ("three-quarter", "three-quarter-right"), ("profile", "profile-right")]
)
def test_a_mirrored_mesh_gives_the_mirrored_view(lopsided, view, twin):
    vertices, faces = lopsided
    picture = render_views(Mesh(vertices, faces), [view], 64)[0]
    mirrored = render_views(Mesh(vertices * MIRROR, faces[:, ::-1]), [twin], 64)[0]
    assert mean_difference(picture, mirrored[:, ::-1]) < 0.01
    assert mean_difference(picture, mirrored) > 0.02


def test_all_views_have_one_scale_and_fit(lopsided_mesh):
    pictures = render_views(lopsided_mesh, list(VIEWS), 96)
    boxes = [box(p) for p in pictures]
    heights = [b[3] - b[2] for b in boxes]
    assert max(heights) - min(heights) <= 2
    assert all(p.shape == (96, 96, 4) for p in pictures)
    assert all(1 < b[0] and b[1] < 94 and 1 < b[2] and b[3] < 94 for b in boxes)
    assert max(max(b[1] - b[0], b[3] - b[2]) for b in boxes) > 84


def test_the_subjects_left_is_on_the_right_and_up_is_up(sphere):
    vertices, faces = sphere
    colours = np.where(vertices[:, :1] > 0.4, [230.0, 20, 20], np.where(vertices[:, 1:2] > 0.4, [20.0, 20, 230], 120.0))
    front = render_views(Mesh(vertices, faces), ["front"], 64, Look(vertex_colours=colours))[0].astype(int)
    assert front[32, 56, 0] > 2 * front[32, 56, 2] and front[8, 32, 2] > 2 * front[8, 32, 0]


def test_profile_looks_to_the_left_and_its_twin_to_the_right(sphere):
    vertices, faces = sphere
    nosed = vertices + np.exp(-20 * ((vertices - [0, 0, 1]) ** 2).sum(1))[:, None] * [0, 0, 1]
    left, right = render_views(Mesh(nosed, faces), ["profile", "profile-right"], 64)
    row = [np.flatnonzero(p[32, :, 3]) for p in (left, right)]
    tall = [np.flatnonzero(p[16, :, 3]) for p in (left, right)]
    assert tall[0].min() - row[0].min() > 10 and row[1].max() - tall[1].max() > 10


def test_a_turntable_starts_in_front_and_comes_round(lopsided):
    vertices, faces = lopsided
    frames = [*turntable(Mesh(vertices, faces), 4, 64)]
    assert len(frames) == 4
    behind = next(turntable(Mesh(vertices * [-1, 1, -1], faces), 4, 64))
    assert mean_difference(frames[2], behind) < 0.01
    assert all(not p[:, [0, -1], 3].any() and not p[[0, -1], :, 3].any() for p in frames)


def test_an_unknown_view_is_refused(sphere):
    with pytest.raises(InputError, match="'above'.*front"):
        render_views(Mesh(*sphere), ["above"], 16)


@pytest.mark.parametrize(("view", "side"), [("front", 0), ("three-quarter", -1), ("three-quarter-right", 1)])
def test_eyes_look_where_the_head_looks(sphere, view, side):
    """An eyeball around all of the mesh, whose dark iris is on the side that the head turns to."""
    vertices, faces = sphere
    look = Look(eyeballs=[(np.zeros(3), 1.01)])
    (picture,) = render_views(Mesh(vertices, faces), [view], 96, look)
    inner = picture[20:76, 12:84, :3].max(-1)
    middle = (np.nonzero(inner < 120)[1].mean() - 35.5) / (0.46 * 96)
    assert middle == pytest.approx(side * np.sin(np.radians(35)), abs=0.15)


def test_vertices_without_triangles_change_no_picture(lopsided):
    vertices, faces = lopsided
    stray = Mesh(np.vstack([vertices, [[50.0, 50, 50]]]), faces)
    for picture, other in zip(render_views(Mesh(vertices, faces), size=64), render_views(stray, size=64), strict=True):
        np.testing.assert_array_equal(picture, other)
    for picture, other in zip(turntable(Mesh(vertices, faces), 3, 64), turntable(stray, 3, 64), strict=True):
        np.testing.assert_array_equal(picture, other)
