import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest

from caricli.methods.animate.pose_rig import RigPoser
from caricli.structures import Mesh, Rig


@pytest.fixture(scope="module")
def rig(ball):
    generator = np.random.default_rng(5)
    vertices, faces = ball
    deltas = generator.normal(size=(9, *vertices.shape)).astype(np.float32)
    return Rig(tuple("abcdefghi"), Mesh(vertices.astype(np.float32), faces), deltas)


@pytest.mark.parametrize("active", [[], [0], [8], [0, 1, 2], [1, 2, 4, 7, 8], [0, 2, 4, 6, 8], list(range(9))])
def test_a_frame_is_the_weighted_sum(rig, active):
    weights = np.zeros(9)
    weights[active] = np.linspace(-0.4, 1.3, len(active))
    expected = rig.neutral.astype(float) + np.einsum("k,kvc->vc", weights, rig.deltas.astype(float))
    poser = RigPoser(rig)
    poser.pose(np.ones(9))  # what came before leaves nothing behind
    posed = poser.pose(weights)
    assert posed.dtype == np.float32
    np.testing.assert_allclose(posed, expected, atol=2e-6)


def test_without_weights_it_is_the_neutral_face_to_the_bit(rig):
    poser = RigPoser(rig)
    poser.pose(np.linspace(0, 1, 9))
    np.testing.assert_array_equal(poser.pose(np.zeros(9)), rig.neutral)


def test_shapes_that_are_zero_are_not_read(rig):
    deltas = rig.deltas.copy()
    deltas[[3, 5]] = np.nan
    # A Rig refuses them.
    poser = RigPoser(SimpleNamespace(names=rig.names, neutral=rig.neutral, deltas=deltas))
    assert np.isfinite(poser.pose([1, 1, 1, 0, 1, 0, 1, 1, 1])).all()


def test_frames_share_one_buffer_that_nobody_else_writes(rig):
    poser = RigPoser(rig)
    first = poser.pose(np.eye(9)[0])
    kept = first.copy()
    second = poser.pose(np.eye(9)[1])
    assert np.shares_memory(first, second) and not np.array_equal(first, kept)
    with pytest.raises(ValueError, match="read-only"):
        second[0] = 0
    with pytest.raises(ValueError, match="broadcast"):
        poser.pose(np.zeros(8))


def test_the_rig_stays_as_it_is(rig):
    neutral, deltas = rig.neutral.copy(), rig.deltas.copy()
    RigPoser(rig).pose(np.ones(9))
    np.testing.assert_array_equal(rig.neutral, neutral)
    np.testing.assert_array_equal(rig.deltas, deltas)


def test_posing_allocates_no_frames(rig):
    poser, weights = RigPoser(rig), np.array([1, 0.5, 0, 0, 1, 0, 0.25, 1, 0])
    poser.pose(weights)
    tracemalloc.start()
    try:
        for _ in range(50):
            poser.pose(weights)
        now, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < rig.neutral.nbytes and now < 1000
