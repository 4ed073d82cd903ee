import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import InputError
from caricli.geometry.join_meshes import join_meshes
from caricli.render.coat import mesh_coat
from caricli.render.shade import Look
from caricli.render.sheets.overlay import draw_landmarks, overlay_mesh
from caricli.structures import Camera, Material, Mesh, Pictures
from caricli.structures.landmarks import POLYLINES, RINGS


def turned(angles=(0, 0, 0)):
    return Rotation.from_euler("yxz", angles, degrees=True).as_matrix() @ np.diag([1.0, -1, -1])


def test_a_known_point_lands_on_its_camera_pixel(sphere):
    camera = Camera(200.0, turned((25, -15, 10)), np.array([70.3, 38.8]))
    point = np.array([0.11, -0.07, 0.05])
    white, black = (
        overlay_mesh(
            np.full((90, 120, 3), paper, np.uint8), Mesh(point + 0.03 * sphere[0], sphere[1]), camera, opacity=1.0
        ).astype(float)
        for paper in (255, 0)
    )
    coverage = 1 - (white - black).mean(-1) / 255
    y, x = np.mgrid[:90, :120]
    found = [(coverage * axis).sum() / coverage.sum() for axis in (x, y)]
    np.testing.assert_allclose(found, 200.0 * camera.rotation[:2] @ point + [70.3, 38.8], atol=0.05)
    assert abs(coverage.sum() / (np.pi * 6**2) - 1) < 0.03


def test_opacity_mixes_picture_and_mesh(sphere):
    paper = np.full((40, 40, 3), (0, 0, 255), np.uint8)
    full, half, none = (
        overlay_mesh(paper, Mesh(*sphere), Camera(12.0, turned(), [20.0, 20]), opacity=o).astype(float)
        for o in (1.0, 0.5, 0.0)
    )
    assert (none == paper).all()
    np.testing.assert_allclose(half, (full + paper) / 2, atol=1)
    assert (full[20, 20] != paper[20, 20]).any()


def test_the_picture_is_not_changed(sphere):
    paper = np.full((40, 40, 3), 200, np.uint8)
    overlay_mesh(paper, Mesh(*sphere), Camera(12.0, turned(), [20.0, 20]))
    draw_landmarks(paper, [[3.0, 3.0]])
    assert (paper == 200).all()


@pytest.mark.parametrize("material", [Material.BUST, Material.CLOTH, Material.GUMS])
def test_what_is_below_a_neck_is_left_to_the_picture(sphere, material):
    paper = np.full((60, 40, 3), 200, np.uint8)
    head, below = Mesh(*sphere), Mesh(sphere[0] - [0, 2.5, 0], sphere[1])
    both = join_meshes([head, below])
    materials = np.repeat([Material.SKIN, material], len(sphere[1]))
    look = Look(coat=mesh_coat(both, Pictures(), materials))
    camera = Camera(10.0, turned(), [20.0, 15])
    whole = overlay_mesh(paper, both, camera, look=look)
    assert ((whole[30:] == paper[30:]).all()) == (material != Material.GUMS)
    assert (whole[15, 20] != paper[15, 20]).any()


@pytest.mark.parametrize(
    ("scale", "rotation", "translation"),
    [
        (0.0, np.eye(3), [0, 0]),
        (np.nan, np.eye(3), [0, 0]),
        (1.0, np.diag([1.0, 1, -1]), [0, 0]),
        (1.0, 2 * np.eye(3), [0, 0]),
        (1.0, np.eye(3), [0, np.inf]),
        (1.0, np.eye(2), [0, 0]),
    ],
)
def test_what_is_no_camera_is_refused(sphere, scale, rotation, translation):
    with pytest.raises(InputError, match="camera"):
        overlay_mesh(np.zeros((8, 8, 3), np.uint8), Mesh(*sphere), Camera(scale, rotation, translation))


def test_landmarks_are_dots_at_their_pixels():
    paper = np.zeros((60, 80, 3), np.uint8)
    picture = draw_landmarks(paper, [[20.25, 30.5], [60, 10]], colour=(10, 200, 30), radius=3)
    assert (picture[10, 60] == (10, 200, 30)).all()
    weight = picture[:, :40, 1].astype(float)
    y, x = np.mgrid[:60, :40]
    np.testing.assert_allclose(
        [(weight * x).sum() / weight.sum(), (weight * y).sum() / weight.sum()], [20.25, 30.5], atol=0.2
    )
    hollow = draw_landmarks(paper, [[60, 10]], radius=5, hollow=True)
    assert not hollow[10, 60].any() and hollow[10, 65].any()


def test_unknown_landmarks_and_lines_to_them_are_left_out():
    points = np.stack([np.linspace(10, 1010, 68), np.full(68, 50.0)], 1)
    points[3] = np.nan
    paper = np.zeros((100, 1020, 3), np.uint8)
    drawn = draw_landmarks(paper, points, radius=1).any(-1)
    x2, x4 = int(points[2, 0]), int(points[4, 0])
    assert not drawn[:, x2 + 4 : x4 - 3].any() and not drawn[0].any()
    assert drawn[50, int(points[1, 0]) : x2].all()  # joined by a line
    dots = draw_landmarks(paper, points, radius=1, lines=False).any(-1)
    assert 0 < dots.sum() < drawn.sum()


def test_open_lines_end_and_rings_close():
    points = np.full((68, 2), np.nan)
    for first, last, closed in [(line[0], line[-1], False) for line in POLYLINES] + [
        (ring[0], ring[-1], True) for ring in RINGS
    ]:
        ends = points.copy()
        ends[first] = 10, 50
        ends[last] = 90, 50
        drawn = draw_landmarks(np.zeros((100, 100, 3), np.uint8), ends, radius=1)
        assert drawn[50, 50].any() == closed


def test_far_points_do_no_harm_and_dots_grow_with_the_picture():
    draw_landmarks(np.zeros((10, 10, 3), np.uint8), [[1e300, -1e300], [np.inf, 3]])
    small, large = (draw_landmarks(np.zeros((n, n, 3), np.uint8), [[n / 2, n / 2]]).any(-1).sum() for n in (300, 3000))
    assert large > 20 * small > 0
