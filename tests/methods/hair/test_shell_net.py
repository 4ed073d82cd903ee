from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.shell_net import ShellNet
from caricli.methods.hair.snap_border import snap_border
from tests.methods.hair.conftest import CAMERA


@pytest.fixture(scope="module")
def shell(sitter):
    return make_shell(sitter.head, CAMERA, sitter.hair)[0]


@pytest.fixture(scope="module")
def sphere(sitter):
    return HeadSphere(sitter.head, ShellSettings(), fine=True)


def _folds(points, shell, sphere):
    """(F,) bool: triangles of a shell, above the skin, that have turned over as seen from the middle of the head."""
    shown = (sphere.heights(points) > 0)[shell.shell.faces].any(1)
    volumes = [np.linalg.det((each - sphere.middle)[shell.shell.faces]) for each in (points, shell.shell.vertices)]
    return shown & (volumes[0] * volumes[1] < 0)


def _shaken(shell, sphere, part):
    """A shell whose vertices (V,) bool are somewhere around where they belong, as high above the skin."""
    longitudes, angles, radii = sphere.seen_from(shell.shell.vertices)
    above = radii - sphere.ground(longitudes, angles)
    longitudes, angles = (
        turn + part * np.random.default_rng(0).normal(0, 0.1, len(turn)) for turn in (longitudes, angles)
    )
    return sphere.points(longitudes, angles, sphere.ground(longitudes, angles) + above), above


def test_what_has_turned_over_is_laid_anew(shell, sphere):
    away = np.linalg.norm(shell.shell.vertices - shell.shell.vertices[3000], axis=1) / sphere.head.height
    points, above = _shaken(shell, sphere, away < 0.08)
    assert _folds(points, shell, sphere).sum() > 50
    laid = ShellNet(shell.shell, sphere).unfolded(points, sphere)
    assert not _folds(laid, shell, sphere).any()
    np.testing.assert_allclose(laid[away > 0.25], shell.shell.vertices[away > 0.25], atol=1e-5)
    np.testing.assert_allclose(sphere.heights(laid), above, atol=2e-5)


def test_what_has_no_folds_stays_as_it_is(shell, sphere):
    longitudes, angles, radii = sphere.seen_from(shell.shell.vertices)
    turned = sphere.points(longitudes + 0.05, angles, radii)
    np.testing.assert_allclose(ShellNet(shell.shell, sphere).unfolded(turned, sphere), turned, atol=1e-5)


def test_hair_that_is_moved_far_has_no_folds(shell, sitter):
    """Of a mask that is elsewhere, and as ragged as those of drawings are."""
    ragged = np.roll(sitter.hair.pixels, 9, axis=1)
    ragged &= np.random.default_rng(0).random((len(ragged) // 8, len(ragged) // 8)).repeat(8, 0).repeat(8, 1) > 0.1
    hair, head, _ = snap_border(shell, sitter.head, CAMERA, replace(sitter.hair, pixels=ragged))
    folds = _folds(hair.shell.vertices, shell, HeadSphere(head, ShellSettings(), fine=True))
    assert folds.sum() < 10


def test_what_comes_out_again_beyond_the_edge_is_told(shell, sphere):
    """A gap of a row near the edge of a quarter of the columns, and a long lock beyond another."""
    net = ShellNet(shell.shell, sphere)
    points = shell.shell.vertices
    rows = (len(points) - 1) // net.columns
    above = np.ones((rows, net.columns), bool)
    above[-1] = False  # the rim, which is under the skin
    above[rows - 4, : net.columns // 4] = False
    above[rows // 3, net.columns // 2] = False
    flat = np.append(True, above.ravel())
    again = net.out_again(flat, points, 0.03 * sphere.head.height)
    expected = np.zeros_like(above)
    expected[rows - 3 : -1, : net.columns // 4] = True
    np.testing.assert_array_equal(again, np.append(False, expected.ravel()))


def test_strips_are_narrower_than_what_has_an_inside(shell, sphere):
    net = ShellNet(shell.shell, sphere)
    rows = (len(shell.shell.vertices) - 1) // net.columns
    chosen = np.zeros((rows, net.columns), bool)
    chosen[: rows // 2] = True
    wide = np.append(True, chosen.ravel())
    chosen[rows // 2 :, 5] = True
    narrow = np.append(True, chosen.ravel())
    np.testing.assert_array_equal(net.without_strips(wide), wide)
    left = net.without_strips(narrow)
    assert (left >= wide).all() and (left & ~wide).sum() <= 2
