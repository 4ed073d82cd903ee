import numpy as np
import pytest

from caricli.methods.parts.bend_lashes import BendSettings, Lashes
from caricli.methods.parts.flesh import Flesh, Hide

COUNT, RINGS, LENGTH = 8, 5, 0.01


@pytest.fixture(scope="module")
def shape():
    """Lashes in a row along x, a millimetre apart, that point to +z."""
    x, z = np.meshgrid(0.001 * np.arange(COUNT), np.linspace(0, LENGTH, RINGS), indexing="ij")
    return np.stack([x, np.zeros_like(x), z], -1).reshape(-1, 3)


@pytest.fixture(scope="module")
def lashes(shape):
    labels = np.repeat(np.arange(COUNT), RINGS)
    return Lashes(shape, labels, np.arange(COUNT) * RINGS, 0.25)


def lid(height):
    """A block behind the lashes, and one above a height that comes over them."""
    corners = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (0, 0.05) for z in (-0.05, 0.05)], float)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([(a, b, c) for a, b, c, d in sides] + [(a, c, d) for a, b, c, d in sides])
    return Flesh(Hide(faces), corners + [0, height, 0], np.zeros(3))


def depths(flesh, points):
    return np.maximum(-flesh.room(points)[0], 0)


def test_lashes_that_nothing_covers_stay_as_they_are(shape, lashes):
    np.testing.assert_array_equal(lashes.bent({1.0: lid(0.001)}, shape, shape, 1.0), shape)


def test_covered_ones_are_bent_out_around_their_roots(shape, lashes):
    over = lid(-0.002)
    assert depths(over, shape).max() > 0.0019
    bent = lashes.bent({1.0: over}, shape, shape, 1.0)
    allowed = lashes.settings.sunk * 0.25 * (1 - lashes.share)
    assert (depths(over, bent) <= allowed + 1e-5).all()
    moved = np.linalg.norm(bent - shape, axis=1)
    assert moved[lashes.roots].max() < moved[RINGS - 1 :: RINGS].min()
    lengths = np.linalg.norm(bent - bent[lashes.roots][lashes.labels], axis=1)
    assert (lengths <= np.linalg.norm(shape - shape[lashes.roots][lashes.labels], axis=1) + 1e-12).all()


def test_where_they_end_does_not_depend_on_where_they_come_from(shape, lashes):
    ends = [lashes.bent({1.0: lid(-0.002)}, start, shape, 1.0) for start in (shape, shape - [0, 0.02, 0])]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-9)


def test_they_stay_out_on_the_way(shape, lashes):
    lids = {share: lid(-0.002 * share) for share in (0.25, 0.5, 0.75, 1.0)}
    bent = lashes.bent(lids, shape, shape, 1.0)
    allowed = lashes.settings.sunk * 0.25 * (1 - lashes.share)
    for share, flesh in lids.items():
        assert (depths(flesh, shape + share * (bent - shape)) <= allowed + 1e-5).all()


def test_lashes_beside_a_covered_one_bend_with_it(shape, lashes):
    asked = np.arange(COUNT) == 0
    far = shape + [0.02, 0, 0] * (lashes.labels >= COUNT // 2)[:, None]
    row = Lashes(far, lashes.labels, lashes.roots, 0.25)
    moved = np.linalg.norm(row.bent({1.0: lid(-0.002)}, far, far, 1.0, asked) - far, axis=1)[RINGS - 1 :: RINGS]
    assert (moved[:2] > 0.0015).all() and moved[COUNT // 2 :].max() < 1e-6


def test_those_that_cannot_be_bent_out_are_shortened(shape, lashes):
    still = Lashes(shape, lashes.labels, lashes.roots, 0.25, BendSettings(rounds=0))
    over = lid(-0.002)
    wall = Flesh(over.hide, over.skin + [0, -0.02, 0.0568], np.zeros(3))
    assert depths(wall, shape).max() > 0.003
    cut = still.bent({1.0: wall}, shape, shape, 1.0)
    assert depths(wall, cut).max() <= still.settings.sunk * 0.25
    np.testing.assert_array_equal(cut[lashes.roots], shape[lashes.roots])
    lengths = cut[RINGS - 1 :: RINGS, 2] / LENGTH
    np.testing.assert_allclose(lengths, still.settings.shorter, atol=1e-12)
    asked = np.arange(COUNT) == 0
    alone = still.bent({1.0: wall}, shape, shape, 1.0, asked)
    np.testing.assert_array_equal(alone[RINGS:], shape[RINGS:])
