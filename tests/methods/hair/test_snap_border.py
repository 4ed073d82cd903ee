from dataclasses import replace

import cv2
import igl
import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.hair import snap_border as module
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.move_skull import lower_skull
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.snap_border import snap_border
from caricli.methods.hair.visible_hair import union_share, visible_hair
from caricli.render.visibility.rasterise import rasterise
from tests.methods.hair.conftest import CAMERA, SIDE


@pytest.fixture(scope="module")
def snapped(shell, sitter):
    return snap_border(shell, sitter.head, CAMERA, sitter.hair)


def _overlap(head, hair, wanted):
    return union_share(visible_hair(head, hair, CAMERA, wanted.shape), wanted)


def test_the_border_is_that_of_the_mask(shell, snapped, sitter):
    hair, head, after = snapped
    before = _overlap(sitter.head, shell, sitter.hair.pixels)
    assert after == _overlap(head, hair, sitter.hair.pixels)
    assert after > 0.97 and 1 - after < 0.5 * (1 - before)


def test_a_shell_as_it_is_made_usually_meets_the_mask_as_well(sitter):
    hair, head = make_shell(sitter.head, CAMERA, sitter.hair)
    assert snap_border(hair, head, CAMERA, sitter.hair)[2] > 0.97


def test_only_what_is_near_the_border_moves(shell, snapped, sitter):
    hair, head, _ = snapped
    away = np.linalg.norm(hair.shell.vertices - shell.shell.vertices, axis=1) / sitter.head.height
    assert np.median(away) < 0.01
    depths = shell.shell.vertices @ CAMERA.rotation[2]
    for share, most in ((0.9, 3e-4), (0.95, 3e-5), (0.99, 1e-7)):
        assert away[depths > np.quantile(depths, share)].max() < most
    features = head.annotation.regions["mouth"]
    np.testing.assert_allclose(head.vertices[features], sitter.head.vertices[features], atol=1e-12)


def test_what_moves_leads_smoothly_to_what_does_not(shell, sitter):
    """Between what the camera sees and what it does not is no crease: neighbours around the head move alike."""
    wide = cv2.dilate(sitter.hair.pixels.astype(np.uint8), np.ones((15, 15))) > 0
    hair, _, _ = snap_border(shell, sitter.head, CAMERA, replace(sitter.hair, pixels=wide))
    moves = (hair.shell.vertices - shell.shell.vertices)[1:].reshape(ShellSettings.rows, -1, 3)
    upper = moves[: ShellSettings.rows // 2]
    bends = np.linalg.norm(np.roll(upper, 1, 1) - 2 * upper + np.roll(upper, -1, 1), axis=-1)
    assert np.quantile(bends, 0.9) < 0.12 * np.linalg.norm(upper, axis=-1).max()


def test_the_skull_is_lowered_where_hair_is_pressed_on_it(shell, sitter):
    low = np.roll(sitter.hair.pixels, 12, axis=0)
    hair, head, after = snap_border(shell, sitter.head, CAMERA, replace(sitter.hair, pixels=low))
    lowered, pressed = (
        CAMERA.project(new.vertices)[:, 1].min() - CAMERA.project(old.vertices)[:, 1].min()
        for new, old in ((head, sitter.head), (hair.shell, shell.shell))
    )
    assert lowered > 1.4 and abs(pressed - 12) < 1
    assert after > _overlap(sitter.head, shell, low) + 0.25


def test_hair_before_bare_skin_goes_under_it(shell, sitter):
    """A side of the mask without hair, wider than borders move."""
    columns = np.nonzero(sitter.hair.pixels.any(0))[0]
    side = np.arange(sitter.hair.pixels.shape[1]) < columns[0] + 0.3 * np.ptp(columns)
    short = replace(sitter.hair, pixels=sitter.hair.pixels & ~side)
    hair, head, _ = snap_border(shell, sitter.head, CAMERA, short)
    skin = rasterise(CAMERA.place(sitter.head.vertices), sitter.head.faces, SIDE, SIDE).face >= 0
    bare = sitter.hair.pixels & side & skin
    before = visible_hair(sitter.head, shell, CAMERA, bare.shape)
    after = visible_hair(head, hair, CAMERA, bare.shape)
    assert before[bare].mean() > 0.8 and after[bare].mean() < 0.25
    assert after[short.pixels].mean() > 0.93


def test_hair_rises_from_where_it_goes_under_the_skin_more_gently_where_it_is_seen_from_aside(shell):
    points = shell.shell.vertices
    over = points[:, 1] < np.quantile(points[:, 1], 0.2)
    assert np.isinf(module._ramp(shell.shell, np.zeros_like(over), CAMERA)).all()
    ramp = module._ramp(shell.shell, over, CAMERA)
    away = np.array([np.linalg.norm(points[over] - point, axis=1).min() for point in points])
    facing = -igl.per_vertex_normals(points, shell.shell.faces) @ CAMERA.rotation[2]
    assert not ramp[over].any()
    np.testing.assert_allclose(ramp[facing < 0.2], 0.6 * away[facing < 0.2])
    np.testing.assert_allclose(ramp[facing > 0.6], 3 * away[facing > 0.6])


def test_hair_that_is_seen_from_aside_hangs_together(shell, sitter):
    """A band of the mask across its lower half, without hair, leaves locks below it that hang on nothing."""
    rows = np.nonzero(sitter.hair.pixels.any(1))[0]
    cut = sitter.hair.pixels.copy()
    cut[rows[0] + int(0.6 * np.ptp(rows)) : rows[0] + int(0.9 * np.ptp(rows))] = False
    hair, head, _ = snap_border(shell, sitter.head, CAMERA, replace(sitter.hair, pixels=cut))
    points, faces = hair.shell.vertices, hair.shell.faces
    sphere = HeadSphere(head, ShellSettings(), fine=True)
    above = np.flatnonzero(sphere.heights(points) > 0.002 * head.height)
    adjacency, _ = vertex_neighbours(faces, len(points))
    _, parts = connected_components(adjacency[above][:, above])
    loose = above[parts != np.bincount(parts).argmax()]
    facing = -igl.per_vertex_normals(points, faces)[loose] @ CAMERA.rotation[2]
    # Burying some turns their neighbours.
    assert (facing < 0).sum() < 25


def test_a_shell_that_is_under_the_skin_stays_there(shell, sitter):
    sphere = HeadSphere(sitter.head, ShellSettings())
    points = sphere.middle + 0.5 * (shell.shell.vertices - sphere.middle)
    hair, _, after = snap_border(
        replace(shell, shell=shell.shell.with_vertices(points)), sitter.head, CAMERA, sitter.hair
    )
    assert after == 0 and np.isfinite(hair.shell.vertices).all()


def test_a_skull_that_is_too_low_is_raised_before_hair(shell, sitter, monkeypatch):
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    low = lower_skull(sitter.head, sphere, 0.94 * sphere.radii)
    skin = rasterise(CAMERA.place(sitter.head.vertices), sitter.head.faces, SIDE, SIDE).face >= 0
    bare = skin & ~sitter.hair.pixels
    shown = []
    for good in (0, 1):
        monkeypatch.setattr(module, "GOOD", good)
        hair, head, _ = snap_border(shell, low, CAMERA, sitter.hair)
        shown.append(visible_hair(head, hair, CAMERA, bare.shape)[bare].mean())
    assert shown[1] < 0.8 * shown[0], shown
