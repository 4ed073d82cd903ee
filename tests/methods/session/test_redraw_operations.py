from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.lines.line_distances import line_distances
from caricli.methods.session.operations import operate
from caricli.methods.session.redraw_operations import face_lines, shown_lines
from caricli.structures import Operation


def lines_of(work, tools):
    return {name: stroke.points for name, stroke in face_lines(work, tools).items()}


def done(work, tools, name, points):
    return operate(work, Operation(name, {"points": np.asarray(points).tolist()}), tools)


def test_a_segment_is_erased_and_the_next_stroke_is_snapped_into_the_gap(start, tools):
    line = lines_of(start, tools)["mouth_upper"]
    middle = line[len(line) // 2] - [0, 2]
    open_ = done(start, tools, "cut", [middle])
    assert open_.gap.curve == "mouth_upper" and open_.face is start.face
    gap = open_.gap
    assert 0 < gap.first < gap.last < len(line) - 1
    bump = np.sin(np.linspace(0, np.pi, gap.last - gap.first + 1))[:, None]
    stroke = line[gap.first : gap.last + 1] + [3, 0] - [0, 6] * bump
    for way in (stroke, stroke[::-1]):
        mended = done(open_, tools, "mend", way)
        new = lines_of(mended, tools)["mouth_upper"]
        assert mended.gap is None
        # Its open ends stay, its middle lies on the stroke.
        assert np.abs(new[[gap.first, gap.last]] - line[[gap.first, gap.last]]).max() < 0.5
    assert new[gap.first + 1 : gap.last, 1].mean() < line[gap.first + 1 : gap.last, 1].mean() - 0.5
    others = lines_of(mended, tools)["brow_left"] - lines_of(start, tools)["brow_left"]
    assert np.abs(others).max() < 0.5


@pytest.mark.parametrize("shift", [0, 5, -40])
def test_any_part_of_the_silhouette_goes_and_the_face_follows_exactly(start, tools, shift):
    line = lines_of(start, tools)["silhouette"]
    ring = np.roll(line[:-1], shift, axis=0)
    open_ = done(start, tools, "cut", ring[10:30])
    shown = [stroke for stroke in shown_lines(open_, tools) if stroke.curve == "silhouette"]
    assert len(shown) == 1 and len(shown[0].points) == len(ring) - 20
    centre = line.mean(0)
    middle = np.sin(np.linspace(0, np.pi, 22))[:, None]
    wanted = ring[9:31] + 12 * middle * (ring[9:31] - centre) / np.linalg.norm(ring[9:31] - centre, axis=1)[:, None]
    mended = done(open_, tools, "mend", wanted)
    new = np.roll(lines_of(mended, tools)["silhouette"][:-1], shift, axis=0)
    gaps = line_distances(new[10:30], [wanted])
    assert gaps.max() < 2.0 and np.linalg.norm(new[20] - ring[20]) > 8


def test_two_erased_parts_become_one(start, tools):
    ring = lines_of(start, tools)["silhouette"][:-1]
    once = done(start, tools, "cut", ring[10:14])
    twice = done(once, tools, "cut", ring[20:24])
    assert (twice.gap.first, twice.gap.last) == (9, 24)
    back = done(done(start, tools, "cut", ring[2:4]), tools, "cut", ring[-6:-3])
    assert back.gap.last - back.gap.first == 2 + 6 + 4 - 1
    with pytest.raises(InputError, match="leaves something"):
        done(start, tools, "cut", np.concatenate([ring, ring[:3]]))


def test_the_other_contour_of_the_mouth_goes_along(start, tools):
    lines = lines_of(start, tools)
    line = lines["mouth_upper"]
    work = start
    for row in (2, len(line) // 2, -3):
        work = done(work, tools, "cut", [line[row] - [0, 2]])
    assert work.gap.curve == "mouth_upper"
    assert (work.gap.first, work.gap.last) == (0, len(line) - 1)
    wider = line.mean(0) + (line - line.mean(0)) * [1.3, 1]
    new = lines_of(done(work, tools, "mend", wider), tools)
    assert np.ptp(new["mouth_lower"][:, 0]) > 1.15 * np.ptp(lines["mouth_lower"][:, 0])


def test_strokes_elsewhere_are_wrinkles_and_what_is_not_meant_is_refused(start, tools):
    wrinkled = done(start, tools, "mend", [[250, 150], [270, 150]])
    assert len(wrinkled.wrinkles) == 1 and wrinkled.face is start.face
    assert len(shown_lines(wrinkled, tools)) == len(shown_lines(start, tools)) + 1
    with pytest.raises(InputError, match="found none there"):
        done(start, tools, "cut", [[2, 2]])
    brow = lines_of(start, tools)["brow_left"]
    chin = lines_of(start, tools)["mouth_lower"]
    with pytest.raises(InputError, match="gap in brow left first"):
        done(done(start, tools, "cut", brow[5:6]), tools, "cut", chin[5:6])
    with pytest.raises(InputError, match="found a dot"):
        done(start, tools, "mend", [[1, 1]])
    assert replace(start).gap is None
