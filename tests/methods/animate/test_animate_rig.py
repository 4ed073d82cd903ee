import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.animate.animate_rig import AnimationSettings, animate_rig
from caricli.methods.animate.smooth_weights import smooth_weights
from caricli.methods.animate.turn_head import turn_head
from caricli.methods.rig.head_expressions import open_head_expressions
from caricli.structures import Mesh, Rig, Track


@pytest.fixture(scope="module")
def rig(ball):
    vertices, faces = ball
    deltas = np.random.default_rng(2).normal(size=(2, *vertices.shape)).astype(np.float32)
    return Rig(("jawOpen", "browInnerUp"), Mesh(vertices.astype(np.float32), faces), deltas)


@pytest.fixture
def track():
    weights = np.array([[0, 0.2], [0.5, -0.1], [1.2, 0.4]])
    return Track(("jawOpen", "grin"), np.arange(3) / 10, weights, np.linspace([0, 0, 0], [0.4, 0, 0], 3))


def test_weights_are_cut_then_scaled_and_the_head_turns(rig, track):
    moving = animate_rig(rig, track, AnimationSettings(scales={"jawOpen": 2.0}))
    np.testing.assert_allclose(moving.animation.weights, [[0, 0], [1, 0], [2, 0]], atol=1e-12)
    assert moving.fps == pytest.approx(10) and moving.driven == [0]
    figures = moving.figures()
    assert figures["clipped"] == 1 and figures["unmatched"] == ("grin",) and figures["undriven"] == ("browInnerUp",)
    assert figures["ranges"] == {"jawOpen": [0.0, 2.0]} and figures["head"] is True and figures["fps"] == moving.fps
    done = []
    frames = [frame.copy() for frame in moving.frames(lambda k, total: done.append((k, total)))]
    assert done == [(1, 3), (2, 3), (3, 3)]
    still = rig.neutral + 2 * rig.deltas[0]
    turned = still @ np.array([[np.cos(0.4), 0, -np.sin(0.4)], [0, 1, 0], [np.sin(0.4), 0, np.cos(0.4)]])
    np.testing.assert_allclose(frames[2], turned, atol=1e-5)


def test_weights_and_the_turning_head_are_smoothed_as_asked(rig, track):
    moving = animate_rig(rig, track, AnimationSettings(smooth=1.5))
    weights, head = (smooth_weights(values, track.times, 1.5) for values in (track.weights, track.head))
    np.testing.assert_allclose(moving.animation.weights[:, 0], np.clip(weights[:, 0], 0, 1), atol=1e-12)
    np.testing.assert_allclose(moving.animation.rotations, turn_head(head), atol=1e-12)


@pytest.mark.parametrize("fps", [None, 50])
def test_a_head_that_turns_round_and_round_is_smoothed_as_any_other(rig, fps):
    times = np.arange(120) / 30
    angles = np.linspace([0, 0, 3.0], [0, 0, 12.0], 120)
    told = (angles + np.pi) % (2 * np.pi) - np.pi
    tracks = [Track(("jawOpen",), times, np.zeros((120, 1)), head) for head in (angles, told)]
    settings = AnimationSettings(smooth=1, fps=fps)
    whole, jumping = (animate_rig(rig, track, settings).animation.rotations for track in tracks)
    np.testing.assert_allclose(np.abs((whole * jumping).sum(1)), 1, atol=1e-9)


def test_the_head_may_keep_still(rig, track):
    moving = animate_rig(rig, track, AnimationSettings(head=False, fps=20))
    assert moving.animation.rotations is None and len(moving.animation.times) == 5
    *_, last = moving.frames(lambda k, total: None)
    np.testing.assert_allclose(last, rig.neutral + rig.deltas[0], atol=1e-6)


def test_a_rig_without_expressions_is_refused(rig, track):
    still = Rig((), rig.mesh, rig.deltas[:0])
    for scales in ({}, {"jawOpen": 1.0}):
        with pytest.raises(InputError, match="expected a rig with expressions"):
            animate_rig(still, track, AnimationSettings(scales=scales))


def test_only_expressions_of_the_rig_are_scaled(rig, track):
    with pytest.raises(InputError, match="jawopen: not among the rig's 2; did you mean 'jawOpen'"):
        animate_rig(rig, track, AnimationSettings(scales={"jawopen": 1.0}))


def test_lips_close_only_what_the_jaw_opens(rig):
    names = ("mouthClose", "jawOpen")
    weights = np.array([[0.7, 0.0], [0.7, 0.5], [0.3, 0.5], [1.4, 1.0]])
    track = Track(names, np.arange(4) / 10, weights)
    closing = Rig(names, rig.mesh, rig.deltas)
    moving = animate_rig(closing, track, AnimationSettings(scales={"jawOpen": 0.5}))
    expected = np.array([[0, 0], [0.25, 0.25], [0.15, 0.25], [0.5, 0.5]])
    np.testing.assert_allclose(moving.animation.weights, expected, atol=1e-12)
    wide = animate_rig(closing, track, AnimationSettings(scales={"jawOpen": 2.0, "mouthClose": 1.0}))
    expected = np.array([[0, 0], [0.7, 1], [0.3, 1], [1, 2]])
    np.testing.assert_allclose(wide.animation.weights, expected, atol=1e-12)
    alone = animate_rig(Rig(("mouthClose", "open"), rig.mesh, rig.deltas), track)
    np.testing.assert_allclose(alone.animation.weights[:, 0], [0.7, 0.7, 0.3, 1], atol=1e-12)


def test_lids_squint_only_as_far_as_a_blink_leaves_them_open(rig):
    names = ("eyeSquintLeft", "eyeBlinkLeft")
    weights = np.array([[0.9, 0.0], [0.9, 0.5], [0.9, 0.9], [0.2, 0.9], [1.2, 1.1]])
    track = Track(names, np.arange(5) / 10, weights)
    moving = animate_rig(Rig(names, rig.mesh, rig.deltas), track)
    expected = np.array([[0.9, 0], [0.9, 0.5], [0.3, 0.9], [0.2, 0.9], [0, 1]])
    np.testing.assert_allclose(moving.animation.weights, expected, atol=1e-12)
    alone = animate_rig(Rig(("eyeSquintLeft", "eyeBlinkRight"), rig.mesh, rig.deltas), track)
    np.testing.assert_allclose(alone.animation.weights[:, 0], [0.9, 0.9, 0.9, 0.2, 1], atol=1e-12)


def test_lids_of_squinting_blinks_do_not_cross():
    templates = open_head_expressions()
    names = ("eyeBlinkLeft", "eyeSquintLeft")
    weights = np.array([[blink, 1.0] for blink in np.linspace(0, 1, 9)])
    deltas = templates.deltas[[templates.names.index(name) for name in names]]
    moving = animate_rig(Rig(names, templates.mesh, deltas), Track(names, np.arange(9) / 10, weights))
    upper, lower = (templates.annotation.curves[f"eye_{lid}_left"][1:-1] for lid in ("upper", "lower"))
    open_ = templates.neutral[upper] - templates.neutral[lower]
    width = (open_**2).sum(1).mean()
    gaps = [((v[upper] - v[lower]) * open_).sum(1).mean() / width for v in moving.frames(lambda k, total: None)]
    assert min(gaps) > -0.03 and gaps[-1] < 0.03
