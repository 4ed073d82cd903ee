import numpy as np
import pytest

from caricli.data.move_parts import NAMES, move_parts, random_hand, random_part_changes
from caricli.structures.landmarks import EAR_RIGHT, EYE_LEFT, EYE_RIGHT, JAW, MOUTH, NOSE

ONE_SIDED = ("eye_asymmetry", "brow_asymmetry", "lean")


@pytest.fixture(scope="module")
def points(head_template):
    """The template's landmarks, exactly symmetric, and the permutation that mirrors them."""
    note = head_template.annotation
    order = note.landmarks.tolist()
    mirror = np.array([order.index(note.mirror[i]) for i in order])
    p = head_template.vertices[note.landmarks]
    return (p + p[mirror] * [-1, 1, 1]) / 2, mirror


def changes(**given):
    return np.array([given.get(name, 0.0) for name in NAMES])


def test_no_change_is_the_identity(points):
    np.testing.assert_allclose(move_parts(points[0], changes()), points[0], atol=1e-12)


def test_the_input_stays_as_it_is(points):
    before = points[0].copy()
    move_parts(points[0], random_part_changes(np.random.default_rng(0)))
    np.testing.assert_array_equal(points[0], before)


@pytest.mark.parametrize("name", NAMES)
def test_every_change_moves_something_and_only_the_lopsided_ones_break_the_symmetry(points, name):
    p, mirror = points
    for amount in (0.1, -0.1):
        moved = move_parts(p, changes(**{name: amount}))
        assert np.abs(moved - p).max() > 1e-4
        asymmetry = np.abs(moved - moved[mirror] * [-1, 1, 1]).max()
        assert (asymmetry > 1e-3) if name in ONE_SIDED else (asymmetry < 1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_random_symmetric_changes_of_a_symmetric_face_are_symmetric(points, seed):
    p, mirror = points
    drawn = random_part_changes(np.random.default_rng(seed), 1.5)
    drawn[[NAMES.index(name) for name in ONE_SIDED]] = 0
    moved = move_parts(p, drawn)
    np.testing.assert_allclose(moved, moved[mirror] * [-1, 1, 1], atol=1e-12)
    assert np.abs(moved - p).max() > 2e-3


@pytest.mark.parametrize("seed", range(30))
def test_mirrored_changes_give_the_mirrored_face(points, seed):
    p, mirror = points
    p = p + np.random.default_rng(100 + seed).normal(size=p.shape) * 0.001
    drawn = random_part_changes(np.random.default_rng(seed))
    other = drawn.copy()
    other[[NAMES.index(name) for name in ONE_SIDED]] *= -1
    expected = move_parts(p, drawn)[mirror] * [-1, 1, 1]
    np.testing.assert_allclose(move_parts(p[mirror] * [-1, 1, 1], other), expected, atol=1e-12)


@pytest.mark.parametrize("seed", range(50))
def test_the_parts_keep_their_order_from_brow_to_chin(points, seed):
    p, _ = points
    q = move_parts(p, random_part_changes(np.random.default_rng(seed), 1.5))
    assert q[33, 1] - q[51, 1] > 0.59 * (p[33, 1] - p[51, 1])
    assert q[51, 1] > q[57, 1]
    assert q[57, 1] - q[8, 1] > 0.49 * (p[57, 1] - p[8, 1])
    assert q[27, 1] > q[33, 1]
    assert q[69, 1] > q[17:27, 1].mean() > q[36:48, 1].mean()


def test_the_nose_pushes_the_mouth_ahead_of_it(points):
    p, _ = points
    q = move_parts(p, changes(nose_size=0.8))
    assert np.ptp(q[NOSE, 0]) > 1.5 * np.ptp(p[NOSE, 0])
    assert q[33, 1] > q[51, 1]
    assert q[MOUTH, 1].mean() < p[MOUTH, 1].mean()


@pytest.mark.parametrize(
    ("name", "measure"),
    [
        ("mouth_width", lambda p: np.ptp(p[MOUTH, 0])),
        ("mouth_open", lambda p: np.ptp(p[MOUTH, 1])),
        ("mouth_smile", lambda p: p[48, 1] - p[51, 1]),
        ("nose_width", lambda p: np.ptp(p[NOSE, 0])),
        ("nose_length", lambda p: p[27, 1] - p[33, 1]),
        ("nose_depth", lambda p: p[30, 2] - p[27, 2]),
        ("nose_droop", lambda p: -p[30, 1]),
        ("chin_height", lambda p: p[57, 1] - p[8, 1]),
        ("chin_width", lambda p: np.ptp(p[[7, 9], 0])),
        ("jaw_width", lambda p: np.ptp(p[[4, 12], 0])),
        ("chin_forward", lambda p: p[8, 2]),
        ("forehead_height", lambda p: p[69, 1] - p[17:27, 1].mean()),
        ("eye_size", lambda p: np.ptp(p[EYE_RIGHT, 0])),
        ("eye_open", lambda p: np.ptp(p[EYE_LEFT, 1])),
        ("eye_apart", lambda p: p[42, 0] - p[39, 0]),
        ("brow_lift", lambda p: p[17:27, 1].mean() - p[36:48, 1].mean()),
        ("ear_size", lambda p: np.ptp(p[EAR_RIGHT, 1])),
        ("ear_out", lambda p: np.ptp(p[[72, 75], 0])),
        ("cheek_width", lambda p: np.ptp(p[JAW, 0])),
    ],
)
def test_a_change_does_what_its_name_says(points, name, measure):
    p, _ = points
    values = [measure(move_parts(p, changes(**{name: amount}))) for amount in (-0.1, 0.0, 0.1)]
    assert values[0] < values[1] < values[2] or (name == "ear_out" and values[0] < values[2])


def test_other_landmarks_are_refused(points):
    with pytest.raises(ValueError, match="81"):
        move_parts(points[0][:68], changes())


def test_random_changes_are_reproducible_and_grow_with_the_strength():
    def draw(strength):
        return np.array([random_part_changes(np.random.default_rng(k), strength) for k in range(200)])

    np.testing.assert_array_equal(draw(1.0), draw(1.0))
    np.testing.assert_allclose(draw(2.0).std(0), 2 * draw(1.0).std(0))
    assert (draw(1.0).std(0) > 0).all()


def test_the_hand_is_smooth_mostly_symmetric_and_in_proportion(points):
    p, mirror = points
    fields = np.array([random_hand(p, np.random.default_rng(k)) for k in range(200)])
    size = np.sqrt((fields**2).mean())
    height = p[69, 1] - p[8, 1]
    assert 0.005 * height < size < 0.05 * height
    distance = np.linalg.norm(p[:, None] - p[None], axis=-1)
    difference = np.sqrt(((fields[:, :, None] - fields[:, None]) ** 2).mean((0, 3)))
    near, far = (distance > 0) & (distance < 0.015 * height), distance > 0.6 * height
    assert near.sum() >= 4 and difference[near].max() < 0.5 * size
    assert difference[(distance > 0) & (distance < 0.03 * height)].mean() < 0.7 * size
    apart = far & ~np.eye(81, dtype=bool)[mirror]
    assert difference[apart].mean() > 1.2 * size
    odd = fields - fields[:, mirror] * [-1, 1, 1]
    even = fields + fields[:, mirror] * [-1, 1, 1]
    assert 0.1 < np.sqrt((odd**2).mean() / (even**2).mean()) < 0.7


def test_the_hand_is_reproducible_and_follows_the_size_of_the_face(points):
    p, _ = points
    first = random_hand(p, np.random.default_rng(3), 0.5)
    np.testing.assert_array_equal(first, random_hand(p, np.random.default_rng(3), 0.5))
    np.testing.assert_allclose(random_hand(2 * p, np.random.default_rng(3), 1.0), 4 * first, rtol=1e-6, atol=1e-9)
