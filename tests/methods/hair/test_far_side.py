"""Hair on the far side of a head that is turned."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.hair.far_side import as_other_side
from caricli.methods.hair.fit_outline import Outline
from caricli.methods.hair.hair_view import HairView
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.hidden_hairline import around_ears
from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.visible_hair import union_share, visible_hair
from caricli.render.visibility.rasterise import rasterise
from tests.methods.hair.conftest import CAMERA, SIDE


@pytest.fixture(scope="module", params=[-50, 50])
def turned(request, sitter):
    """A camera that sees the left or the right side of a head, and a mask of hair that hides the ear and the nape."""
    turn = Rotation.from_euler("y", request.param, degrees=True).as_matrix()
    camera = replace(CAMERA, rotation=CAMERA.rotation @ turn)
    head = sitter.head
    placed = camera.place(head.vertices)
    shown = rasterise(placed, head.faces, SIDE, SIDE).face >= 0
    rows, columns = np.mgrid[:SIDE, :SIDE]
    ear = camera.project(head.vertices[head.annotation.regions["ear_left" if request.param < 0 else "ear_right"]])
    x, y = ear.mean(0)
    backwards = np.sign(x - camera.project(head.vertices[head.annotation.landmarks[[30]]])[0, 0])
    behind = backwards * (columns - x)
    hair = (behind > -25) & (rows < y + 45) & ((columns - x + 5 * backwards) ** 2 + (rows - y + 40) ** 2 < 95**2)
    return camera, HairMask(hair, ~(hair | shown), 0.0, True)


def test_the_far_side_has_hair_as_long_as_the_near_one(sitter, turned):
    camera, mask = turned
    hair, head = make_shell(sitter.head, camera, mask)
    assert union_share(visible_hair(head, hair, camera, mask.pixels.shape), mask.pixels) > 0.8
    sphere = HeadSphere(head, ShellSettings(), fine=True)
    longitudes, angles, radii = sphere.seen_from(hair.shell.vertices)
    above = radii > sphere.ground(longitudes, angles)
    # Where ears are, and behind them.
    sides = above & (np.abs(np.degrees(longitudes)) > 80) & (np.abs(np.degrees(longitudes)) < 150)
    lowest = [angles[sides & (side * longitudes > 0)].max() for side in (-1, 1)]
    assert np.degrees(min(lowest)) > 100 and np.degrees(abs(lowest[0] - lowest[1])) < 8
    behind = np.degrees(np.mod(longitudes, 2 * np.pi)) // 10
    lows = [np.degrees(angles[above & (behind == k)].max()) for k in range(12, 24)]
    assert np.abs(np.diff(lows)).max() < 12


def test_an_ear_on_the_far_side_is_under_hair_as_the_other_one(sitter, turned):
    camera, mask = turned
    nothing = HairMask(np.zeros_like(mask.pixels), mask.behind, 0.0, True)
    clear = []
    for hair in (mask, nothing):
        sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
        view = HairView(sitter.head, camera, hair, Outline.of(mask, sphere, camera, ShellSettings().bins))
        free, _ = around_ears(sphere, view, ShellSettings())
        clear.append([(free[:, np.sin(sphere.longitudes) * side > 0] > 0).all() for side in (-1, 1)])
    assert clear == [[True, True], [False, False]]


def test_an_ear_on_the_far_side_lies_under_its_hair(sitter, turned):
    camera, mask = turned
    head = make_shell(sitter.head, camera, mask)[1]
    names = ("ear_left", "ear_right")
    far, near = names if camera.rotation[2, 0] > 0 else names[::-1]
    before, after = (
        {name: np.abs(each.vertices[head.annotation.regions[name], 0]).max() for name in names}
        for each in (sitter.head, head)
    )
    assert after[far] < before[far] - 0.02 * head.height
    assert after[near] == pytest.approx(before[near], abs=0.01 * head.height)
    assert flipped_triangles(head.vertices, head.gradients).mean() < 1e-3


def test_a_head_that_looks_at_the_camera_has_what_its_picture_shows(sitter):
    sphere = HeadSphere(sitter.head, ShellSettings())
    left = np.random.default_rng(5).uniform(0, 1, sphere.radii.shape)
    total = sphere.radii + 0.02 * left
    hidden = np.broadcast_to((np.sin(sphere.longitudes) > 0).astype(float), left.shape)
    same = as_other_side(sphere, CAMERA, left, total, hidden)
    np.testing.assert_array_equal(same[0], left)
    np.testing.assert_array_equal(same[1], total)


def test_the_far_side_is_as_long_and_as_thick(sitter, turned):
    camera, _ = turned
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    side = np.sin(sphere.longitudes) * np.sign(camera.rotation[2, 0])
    hidden = np.broadcast_to((side > 0).astype(float), sphere.radii.shape)
    left = np.random.default_rng(5).uniform(0.01, 0.02, hidden.shape)
    above = np.broadcast_to(0.02 + 0.01 * np.sin(sphere.longitudes), hidden.shape)
    new, total = as_other_side(sphere, camera, left, sphere.radii + above, hidden)
    middle = (sphere.angles > np.radians(50)) & (sphere.angles < np.radians(120))
    other = -np.arange(len(side))
    far, near = np.ix_(middle, side > 0.9), np.ix_(middle, side < -0.9)
    np.testing.assert_allclose(new[far], left[:, other][far])
    np.testing.assert_allclose((total - sphere.radii)[far], above[:, other][far])
    np.testing.assert_array_equal(new[near], left[near])


def test_hair_has_no_gap_between_both_sides(sitter, turned):
    camera, _ = turned
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    side = np.sin(sphere.longitudes) * np.sign(camera.rotation[2, 0])
    hidden = np.broadcast_to((side > 0.2).astype(float), sphere.radii.shape)
    gap = (np.abs(side - 0.05) < 0.1) & (np.cos(sphere.longitudes) < 0)
    left = np.broadcast_to(np.where(gap, -0.02, 0.02), hidden.shape)
    new, _ = as_other_side(sphere, camera, left, sphere.radii + 0.02, hidden)
    middle = (sphere.angles > np.radians(50)) & (sphere.angles < np.radians(120))
    assert (new[middle] > 0).all()


def test_what_hangs_beside_the_neck_on_the_far_side_is_not_what_the_picture_has_there(sitter, turned):
    camera, _ = turned
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    side = np.sin(sphere.longitudes) * np.sign(camera.rotation[2, 0])
    left = np.broadcast_to(np.where(side > 0, -0.02, 0.02), sphere.radii.shape)
    new, _ = as_other_side(sphere, camera, left, sphere.radii + 0.02, np.zeros(left.shape))
    middle = (sphere.angles > np.radians(60)) & (sphere.angles < np.radians(110))
    assert (new[np.ix_(middle, side > 0.95)] > 0).all()
