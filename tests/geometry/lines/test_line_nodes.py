import numpy as np
import pytest

from caricli.geometry.lines.line_nodes import _left, line_nodes
from caricli.geometry.lines.match_line import resample

STEPS = np.array([0, 0.4, 1.1, 1.3, 2.2, 2.5, np.pi])
NODES = np.stack([30 * np.cos(STEPS), 20 * np.sin(STEPS) + [0, 1, -1, 1, -1, 1, 0]], 1)


def straight(pieces):
    return np.vstack([resample(NODES[k : k + 2], pieces + 1)[:-1] for k in range(6)] + [NODES[-1:]])


def rounded(pieces):
    """The curve of Catmull and Rom."""
    ends = np.vstack([2 * NODES[0] - NODES[1], NODES, 2 * NODES[-1] - NODES[-2]])
    t = np.arange(pieces)[:, None] / pieces
    line = []
    for a, b, c, d in zip(ends[:-3], ends[1:-2], ends[2:-1], ends[3:], strict=True):
        line.append(b + t / 2 * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a))))
    return np.vstack([*line, NODES[-1:]])


@pytest.mark.parametrize("line", [NODES, straight(3), straight(10), rounded(5), rounded(12)])
def test_a_line_gives_back_the_points_that_it_was_drawn_through(line):
    rows = line_nodes(np.round(line, 2), len(NODES))
    assert rows is not None
    np.testing.assert_allclose(line[np.rint(rows).astype(int)], NODES, atol=1e-9)


@pytest.mark.parametrize("count", [5, 8, 9, 10, 31, 48, 200])
def test_a_line_with_its_points_at_equal_distances_tells_none(count):
    assert line_nodes(resample(rounded(40), count), len(NODES)) is None


def test_a_line_of_a_hand_tells_none():
    noise = np.random.default_rng(0).normal(0, 0.3, (61, 2))
    assert line_nodes(resample(rounded(10), 61) + noise, len(NODES)) is None


def test_a_line_of_very_many_points_is_not_looked_at():
    assert line_nodes(rounded(300), len(NODES)) is None


def test_pieces_fit_cubics_of_common_slopes_and_nothing_else():
    """Hermite's cubics with slopes at random, evaluated by their Bezier points; two slopes at a node do not fit."""
    generator, pieces = np.random.default_rng(3), 20
    values, slopes = generator.normal(size=(2, 6, 2))
    t = np.arange(pieces)[:, None] / pieces

    def line(leaving, arriving):
        parts = []
        for k in range(5):
            bends = values[k], values[k] + leaving[k] / 3, values[k + 1] - arriving[k + 1] / 3, values[k + 1]
            weights = (1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3
            parts.append(sum(weight * bend for weight, bend in zip(weights, bends, strict=True)))
        return np.vstack([*parts, values[-1:]])

    assert _left(line(slopes, slopes), 6, False, True) < 1e-12
    assert _left(line(slopes, -slopes), 6, False, True) > 0.01
    assert _left(line(slopes, slopes), 6, False, False) > 0.01
    assert _left(line(slopes, slopes), 6, True, True) > 0.01
    np.testing.assert_allclose(line_nodes(line(slopes, slopes), 6), pieces * np.arange(6))


def test_pieces_from_middle_to_middle_fit_what_bends_there():
    """One cubic, of which any pieces are; and straight lines that meet in the middles."""
    t = np.linspace(0, 1, 61)[:, None]
    assert _left(np.hstack([t**3 - t, t**2]), 7, True, True) < 1e-12
    middles = np.array([0, 0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6])
    heights = np.random.default_rng(0).normal(size=8)
    bent = np.stack([6 * t[:, 0], np.interp(6 * t[:, 0], middles, heights)], 1)
    assert _left(bent, 7, True, False) < 1e-12 < 0.01 < _left(bent, 7, False, False)


def test_lines_of_hands_tell_none_however_they_tremble():
    for seed in range(40):
        for count in (9, 13, 19, 40):
            noise = np.random.default_rng(seed).normal(0, 3.0, (count, 2))
            assert line_nodes(resample(rounded(40), count) + noise, len(NODES)) is None


def test_fewer_points_than_nodes_tell_none():
    assert line_nodes(NODES[:5], len(NODES)) is None


@pytest.mark.parametrize("shift", [0, 3, 17, 100])
def test_a_straight_line_tells_none_wherever_it_is(shift):
    assert line_nodes(np.linspace([10, 20], [100, 37], 25) + shift, len(NODES)) is None
