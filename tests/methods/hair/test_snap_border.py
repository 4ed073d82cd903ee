from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.hair import snap_border as module
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.make_shell import lower_skull, make_shell
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.snap_border import snap_border, union_share, visible_hair
from caricli.render.rasterise import rasterise
from tests.methods.hair.conftest import CAMERA, SIDE


@pytest.fixture(scope="module")
def shell(sitter):
    return make_shell(sitter.head, CAMERA, sitter.hair)[0]


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


def test_only_what_is_near_the_border_moves(shell, snapped, sitter):
    hair, head, _ = snapped
    away = np.linalg.norm(hair.shell.vertices - shell.shell.vertices, axis=1) / sitter.head.height
    assert np.median(away) < 0.01
    behind = shell.shell.vertices @ CAMERA.rotation[2] > np.quantile(shell.shell.vertices @ CAMERA.rotation[2], 0.9)
    assert away[behind].max() < 1e-9
    features = head.annotation.regions["mouth"]
    np.testing.assert_allclose(head.vertices[features], sitter.head.vertices[features], atol=1e-12)


def test_the_skull_is_lowered_where_hair_is_pressed_on_it(shell, sitter):
    low = np.roll(sitter.hair.pixels, 12, axis=0)
    _, head, after = snap_border(shell, sitter.head, CAMERA, replace(sitter.hair, pixels=low))
    assert CAMERA.project(head.vertices)[:, 1].min() > CAMERA.project(sitter.head.vertices)[:, 1].min() + 2
    assert after > _overlap(sitter.head, shell, low) + 0.05


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


def test_a_skull_that_is_too_low_is_raised_before_hair(shell, sitter, monkeypatch):
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    low = lower_skull(sitter.head, sphere, 0.94 * sphere.radii)
    skin = rasterise(CAMERA.place(sitter.head.vertices), sitter.head.faces, SIDE, SIDE).face >= 0
    bare = skin & ~sitter.hair.pixels
    shown = []
    for good in (0, 1):
        monkeypatch.setattr(module, "_GOOD", good)
        hair, head, _ = snap_border(shell, low, CAMERA, sitter.hair)
        shown.append(visible_hair(head, hair, CAMERA, bare.shape)[bare].mean())
    assert shown[1] < 0.8 * shown[0], shown
