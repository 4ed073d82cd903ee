import cv2
import numpy as np
import pytest
from scipy.spatial import KDTree

from caricli.geometry.lines.trace_lines import trace_lines


def drawn(*lines, width=3, size=200):
    ink = np.zeros((size, size), np.uint8)
    for line in lines:
        cv2.polylines(ink, [np.array(line, np.int32)], False, 255, width)
    return ink > 0


def test_a_line_from_end_to_end():
    (line,) = trace_lines(drawn([[20, 50], [180, 50]]), 10)
    assert np.abs(line.points[:, 1] - 50).max() < 1 and 2 <= line.width <= 6
    assert abs(np.ptp(line.points[:, 0]) - 160) < 6


@pytest.mark.parametrize("width", [3, 5, 9])
@pytest.mark.parametrize("top", [0, 60])
def test_a_line_is_as_wide_as_its_ink_also_at_the_edge(width, top):
    ink = np.zeros((100, 200), bool)
    ink[top : top + width, 20:180] = True
    (line,) = trace_lines(ink, 10)
    assert abs(line.width - width) <= 0.6
    assert np.abs(line.points[3:-3, 1] - top - (width - 1) / 2).max() < 0.6


def test_lines_have_no_steps_of_pixels():
    (line,) = trace_lines(drawn([[20, 50], [180, 90]]), 10)
    inner = line.points[2:-2]
    assert np.abs(np.polyval(np.polyfit(*inner.T, 1), inner[:, 0]) - inner[:, 1]).max() < 0.25
    assert 2 < np.median(np.linalg.norm(np.diff(line.points, axis=0), axis=1)) < 5


def test_crossing_lines_go_straight_on():
    lines = trace_lines(drawn([[20, 20], [180, 180]], [[20, 180], [180, 20]]), 10)
    assert len(lines) == 2
    for line in lines:
        assert abs(np.ptp(line.points[:, 0]) - 160) < 8
        slope = np.polyfit(*line.points.T, 1)[0]
        assert abs(abs(slope) - 1) < 0.05


def test_a_branch_ends_at_the_line_that_it_meets():
    lines = trace_lines(drawn([[20, 100], [180, 100]], [[100, 100], [100, 180]]), 10)
    assert [round(np.ptp(line.points, axis=0).max(), -1) for line in lines] == [160, 80]
    assert np.abs(lines[1].points[:, 1] - 100).min() < 1


def test_rings_are_closed():
    angles = np.linspace(0, 2 * np.pi, 100)
    ring = np.column_stack([100 + 60 * np.cos(angles), 100 + 60 * np.sin(angles)])
    (line,) = trace_lines(drawn(ring), 10)
    assert np.array_equal(line.points[0], line.points[-1])
    assert np.abs(np.linalg.norm(line.points - 100, axis=1) - 60).max() < 1.5


def test_dirt_and_stubs_are_left_out():
    ink = drawn([[20, 100], [180, 100]], [[100, 100], [100, 106]], [[50, 50], [53, 52]])
    lines = trace_lines(ink, 12)
    assert len(lines) == 1
    assert trace_lines(np.zeros((50, 50), bool), 10) == []


def test_every_pixel_of_a_scribble_is_near_a_line():
    generator = np.random.default_rng(0)
    ink = drawn(*(generator.integers(10, 190, (4, 2)) for _ in range(5)))
    points = np.concatenate([line.points for line in trace_lines(ink, 6)])
    pixels = np.argwhere(ink)[:, ::-1]
    assert (KDTree(points).query(pixels)[0] < 4).mean() > 0.97


ROUGH = """
.............#
........#...#.
.......#.#.#..
........###...
.........#....
.....#...#....
....#.###.....
.....###......
.......#......
......#.......
"""
"""Two crossings with a pixel between them and stubs of two at either."""


def test_a_line_goes_on_over_crossings_beside_each_other():
    ink = np.zeros((60, 60), bool)
    ink[20:30, 20:34] = [[letter == "#" for letter in row] for row in ROUGH.split()]
    ends = np.arange(15)
    ink[19 - ends, 34 + ends] = True
    ink[30 + ends, 25 - ends] = True
    (line,) = trace_lines(ink, 8)
    assert np.ptp(line.points, axis=0).min() > 35


def segment(angle, length=160):
    """Through the middle of a picture; degrees."""
    way = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    return np.rint(100 + np.outer([-length / 2, length / 2], way))


@pytest.mark.parametrize("apart", [45, 60, 75, 90])
@pytest.mark.parametrize("width", [2, 4])
def test_lines_that_cross_at_any_angle_go_straight_on(apart, width):
    for angle in range(0, 180, 15):
        lines = trace_lines(drawn(segment(angle), segment(angle + apart), width=width), 10)
        assert len(lines) == 2
        for line in lines:
            assert np.linalg.norm(line.points[-1] - line.points[0]) > 145
            aside = [(line.points - 100) @ [-np.sin(turn), np.cos(turn)] for turn in np.radians([angle, angle + apart])]
            assert min(np.abs(each).max() for each in aside) < 3.5


@pytest.mark.parametrize("turn", range(4))
def test_a_line_that_crosses_itself_is_one_line(turn):
    t = np.linspace(-1.6, 1.6, 200)
    loop = np.stack([30 * (t**3 - t), 30 * (t**2 - 1)], 1)
    for _ in range(turn):
        loop = loop[:, ::-1] * [-1, 1]
    (line,) = trace_lines(drawn(loop + 100), 10)
    steps = np.linalg.norm(np.diff(line.points, axis=0), axis=1)
    assert steps.max() < 6 and steps.sum() > 0.93 * np.linalg.norm(np.diff(loop, axis=0), axis=1).sum()


def test_an_eight_is_one_line_and_so_is_an_arch():
    t = np.linspace(0, 2 * np.pi, 200)
    (eight,) = trace_lines(drawn(np.stack([100 + 70 * np.sin(t), 100 + 60 * np.sin(2 * t)], 1)), 10)
    steps = np.linalg.norm(np.diff(eight.points, axis=0), axis=1)
    assert steps.max() < 6 and steps.sum() > 500
    (arch,) = trace_lines(drawn(np.stack([100 + 60 * np.cos(t / 2), 120 - 60 * np.sin(t / 2)], 1)), 10)
    assert np.ptp(arch.points[:, 0]) > 115


@pytest.mark.parametrize("way", [(1, 0), (0, 1), (-1, 0), (0, -1)])
def test_a_branch_to_any_side_reaches_its_line(way):
    way = np.array(way)
    across = np.array([-way[1], way[0]])
    line, branch = trace_lines(drawn([100 - 80 * across, 100 + 80 * across], [[100, 100], 100 + 80 * way]), 10)
    assert np.abs((line.points - 100) @ way).max() < 1.5
    assert np.abs((branch.points - 100) @ way).min() < 1


def test_three_lines_that_meet_alike_stay_three():
    ways = np.radians([0, 120, 240])
    lines = trace_lines(drawn(*([[100, 100], 100 + 70 * np.array([np.sin(a), -np.cos(a)])] for a in ways)), 10)
    assert len(lines) == 3 and all(50 < np.linalg.norm(line.points[-1] - line.points[0]) < 75 for line in lines)


def test_a_stub_at_a_corner_does_not_part_its_line():
    (line,) = trace_lines(drawn([[100, 30], [100, 100], [30, 100]], [[100, 100], [107, 107]]), 15)
    assert np.linalg.norm(line.points[0] - line.points[-1]) > 90


def test_a_rung_shorter_than_the_shortest_line_is_left_out():
    ladder = drawn([[20, 60], [180, 60]], [[20, 72], [180, 72]], [[100, 60], [100, 72]])
    assert [round(np.ptp(line.points[:, 0]), -1) for line in trace_lines(ladder, 16)] == [160, 160]


def test_the_width_of_a_line_is_not_that_of_a_blot_on_it():
    ink = drawn([[20, 100], [180, 100]]).astype(np.uint8)
    (line,) = trace_lines(cv2.circle(ink.copy(), (100, 100), 9, 1, -1) > 0, 20)
    assert line.width == trace_lines(ink > 0, 20)[0].width


def test_a_ring_has_no_kink_where_it_begins():
    angles = np.linspace(0, 2 * np.pi, 100)
    (line,) = trace_lines(drawn(np.column_stack([100 + 60 * np.cos(angles), 100 + 60 * np.sin(angles)])), 10)
    steps = np.diff(line.points, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    turns = (steps * np.roll(steps, 1, axis=0)).sum(1)
    assert turns.min() > np.cos(np.radians(20))


@pytest.mark.parametrize(("width", "open_"), [(4, 60), (7, 50), (7, 60), (9, 60), (9, 90), (12, 75)])
def test_three_lines_that_meet_at_two_corners_are_three_lines_or_a_ring_with_one_in_it(width, open_):
    """Lips and the line between them, from corner to corner: they came as one line that turned back at each."""
    across = np.linspace(60, 340, 80)
    arch = np.sin((across - 60) / 280 * np.pi)
    ink = np.zeros((300, 400), np.uint8)
    for high in (-open_, 0.1 * open_, open_):
        line = np.column_stack([across, 150 + high * arch])
        cv2.polylines(ink, [np.round(16 * line).astype(np.int32)], False, 255, width, cv2.LINE_AA, 4)
    lines = trace_lines(ink > 127, 12)
    middle = [line for line in lines if np.abs(line.points[:, 1] - 155).max() < 25]
    assert len(middle) == 1 and 250 < np.ptp(middle[0].points[:, 0]) < 290
    rest = [line for line in lines if line is not middle[0]]
    reach = sorted((line.points[:, 1].min() < 140, line.points[:, 1].max() > 165) for line in rest)
    assert reach in ([(True, True)], [(False, True), (True, False)])


@pytest.mark.parametrize("angle", [0, 20, 45, 70])
def test_short_lines_are_as_long_in_all_directions(angle):
    way = 10 * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    ink = drawn([100 - way, 100 + way])
    assert len(trace_lines(ink, 16)) == 1 and not trace_lines(ink, 27)


@pytest.mark.parametrize("seed", range(4))
def test_mirrored_ink_has_the_mirror_images_of_the_lines(seed):
    """Thinning takes pixels off one side first, and crossings were met in another order."""
    generator = np.random.default_rng(seed)
    ink = drawn(*(generator.integers(10, 190, (4, 2)) for _ in range(6)), width=5)
    lines, mirrored = (trace_lines(each, 8) for each in (ink, ink[:, ::-1]))
    assert len(lines) == len(mirrored)
    for a, b in zip(lines, mirrored, strict=True):
        assert np.allclose(a.points * [-1, 1] + [ink.shape[1] - 1, 0], b.points) and a.width == b.width
