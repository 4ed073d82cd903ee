from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.train.strokes.beside_lines import BesideSettings, lines_beside
from caricli.methods.train.strokes.drawn_page import PageSettings, draw_page
from caricli.template.feature_curves import feature_curves
from tests.named_lines import points_by_curve

PLAIN = PageSettings(
    stretched=0, widened=0, exact=1, seldom=0, ears=0, lips=0, lids=0, outline=0, doubled=0, closed=0, bare=0, broken=0,
    again=0, tilt=0,
)  # fmt: skip


@pytest.fixture(scope="module")
def curves(head_template):
    own = feature_curves(head_template.annotation)
    return points_by_curve(draw_sketch(head_template.vertices, own, canvas_camera(head_template.vertices, own)))


def pages(curves, settings, count=40):
    return [draw_page(curves, [], np.random.default_rng(seed), settings) for seed in range(count)]


def test_a_page_that_nobody_changes_is_the_face_and_what_is_beside_it(curves):
    for page in pages(curves, PLAIN, 5):
        for name, line in zip(page.names, page.lines, strict=True):
            if name is not None:
                np.testing.assert_allclose(line, curves[name], atol=1e-9)
        assert [name for name in page.names if name] == list(curves)


def test_everything_is_in_the_window(curves):
    for page in pages(curves, PageSettings()):
        inside = np.abs(page.window.inside(np.concatenate(page.lines)))
        assert 0.75 < inside.max() <= 1


def test_the_same_draw_is_the_same_page(curves):
    one, two = (draw_page(curves, [], np.random.default_rng(3)) for _ in range(2))
    assert one.names == two.names and all(np.array_equal(a, b) for a, b in zip(one.lines, two.lines, strict=True))


@pytest.mark.parametrize(
    ("chance", "start"),
    [("seldom", "nostril"), ("ears", "ear"), ("lips", "mouth_upper"), ("lids", "eye_lower"), ("outline", "silhouette")],
)
def test_curves_are_left_out_as_often_as_asked(curves, chance, start):
    drawn = [
        any(name and name.startswith(start) for name in page.names)
        for page in pages(curves, replace(PLAIN, **{chance: 0.5}), 200)
    ]
    assert 0.35 < np.mean(drawn) < 0.65


def test_a_silhouette_without_its_crown_goes_from_ear_to_ear(curves):
    (page,) = pages(curves, replace(PLAIN, bare=1), 1)
    jaw = page.lines[page.names.index("silhouette")]
    whole = curves["silhouette"]
    assert jaw[:, 1].max() == whole[:, 1].max() and jaw[:, 1].min() > whole[:, 1].min() + 0.1 * np.ptp(whole[:, 1])
    assert np.linalg.norm(np.diff(jaw, axis=0), axis=1).max() < 0.1 * np.ptp(whole[:, 1])


def test_features_are_moved_as_one_and_alike_on_both_sides(curves):
    moved = [dict(zip(page.names, page.lines, strict=True)) for page in pages(curves, replace(PLAIN, exact=0), 60)]
    sizes = np.array([[np.ptp(page[f"eye_upper_{side}"][:, 0]) for side in ("left", "right")] for page in moved])
    assert sizes.std() > 2 and np.corrcoef(sizes.T)[0, 1] > 0.5
    for page in moved[:5]:
        gaps = [np.linalg.norm(page["eye_upper_left"][0] - page["eye_lower_left"][0]) for page in (page, curves)]
        assert gaps[0] < 3 * gaps[1] + 1


def test_faces_become_longer_and_wider_in_places(curves):
    settings = replace(PLAIN, stretched=0.3, widened=0.2)
    heights = [np.ptp(page.lines[page.names.index("silhouette")][:, 1]) for page in pages(curves, settings)]
    own = np.ptp(curves["silhouette"][:, 1])
    assert min(heights) < 0.9 * own and max(heights) > 1.1 * own


def test_what_is_beside_a_face(curves):
    every = BesideSettings(0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1)
    lines = lines_beside(curves, np.random.default_rng(0), every)
    points = np.concatenate(lines)
    face = np.concatenate(list(curves.values()))
    assert points[:, 1].max() > face[:, 1].max() and len(lines) > 12
    assert all(np.isfinite(line).all() and line.shape[1] == 2 and len(line) > 1 for line in lines)
    assert lines_beside(curves, np.random.default_rng(0), replace(every, bare=1)) == []


def test_irises_are_between_the_lids(curves):
    eyes = BesideSettings(0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0)
    irises = lines_beside(curves, np.random.default_rng(1), eyes)
    assert len(irises) == 2
    for line, side in zip(irises, ("left", "right"), strict=True):
        lids = np.concatenate([curves[f"eye_{which}_{side}"] for which in ("upper", "lower")])
        assert (line.mean(0) > lids.min(0)).all() and (line.mean(0) < lids.max(0)).all()


def test_a_face_of_few_curves_has_something_beside_it_too(curves):
    for names in (["nose"], ["eye_upper_left"], ["mouth_upper", "ear_left"]):
        few = {name: curves[name] for name in names}
        for seed in range(20):
            page = draw_page(few, [], np.random.default_rng(seed))
            assert np.isfinite(np.concatenate(page.lines)).all()
