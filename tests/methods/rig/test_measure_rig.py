from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.rig.add_eyeballs import Eyeball
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.rig.measure_rig import curve_gap, measure_rig
from caricli.structures import Mesh
from caricli.template.annotation import Annotation
from caricli.template.template import Template

ROWS, COLUMNS = 9, 7
LOWER, UPPER = 2, 6
NAMES = ("eyeBlinkLeft", "jawOpen", "mouthClose", "nothing")


def row(y):
    return np.arange(COLUMNS) + y * COLUMNS


@pytest.fixture(scope="module")
def neutral():
    y, x = np.mgrid[:ROWS, :COLUMNS].astype(float)
    return np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)


@pytest.fixture(scope="module")
def faces():
    corner = (np.arange(ROWS - 1)[:, None] * COLUMNS + np.arange(COLUMNS - 1)).ravel()
    quads = np.stack([corner, corner + 1, corner + COLUMNS + 1, corner + COLUMNS], axis=1)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


@pytest.fixture(scope="module")
def annotation():
    """Row UPPER is the upper lid and lip, LOWER the lower one."""
    curves = {name: row(LOWER if "lower" in name else UPPER)
              for name in ("eye_upper_left", "eye_lower_left", "mouth_inner_upper", "mouth_inner_lower")}  # fmt: skip
    regions = {"eyes_left": row(4), "eye_socket_left": row(LOWER)}
    return Annotation(np.zeros(68, int), (), curves, regions, None, {}, {})


def lowered(neutral, *amounts):
    """Displacements that lower row UPPER, one of each amount."""
    deltas = np.zeros((len(amounts), *neutral.shape))
    for delta, amount in zip(deltas, amounts, strict=True):
        delta[row(UPPER), 1] = -amount
    return deltas


@pytest.fixture(scope="module")
def templates(neutral, faces, annotation):
    """The blink ends 0.05 above the lower row; mouthClose undoes a jawOpen of 1 and goes as far."""
    mesh = Template(neutral, faces, annotation=annotation)
    return ExpressionTemplates(NAMES, mesh, lowered(neutral, 3.95, -1, 4.95, 0))


def test_lips_that_a_jaw_does_not_open_have_no_gap(templates, neutral):
    closed = neutral.copy()
    closed[row(UPPER), 1] = closed[row(LOWER), 1]
    still = np.zeros_like(templates.deltas)
    measures = measure_rig(closed, still, replace(templates, names=NAMES, deltas=still))
    assert measures.lip_gap == measures.lips_open == 0


def test_gap_between_polylines():
    x = np.linspace(0, 1, 5)
    line = np.stack([x, 0 * x, 0 * x], axis=1)
    raised = line + [0.0, 0.3, 0.4]
    both, ids = np.concatenate([line, raised]), np.arange(5)
    assert curve_gap(both, ids + 5, ids) == pytest.approx(0.5)
    # Points lie between those of the other line; what sticks out is measured to its end.
    shifted = np.concatenate([line, line + [0.1, 0.2, 0]])
    assert curve_gap(shifted, ids + 5, ids) == pytest.approx(0.2)
    ahead = np.concatenate([line, line + [1.0, 0, 0]])
    assert curve_gap(ahead, ids + 5, ids) == pytest.approx(np.mean([0.25, 0.5, 0.75]))


def test_gaps_are_shares_of_what_was_open(neutral, templates):
    measures = measure_rig(neutral, lowered(neutral, 3, -1, 4, 0), templates)
    assert measures.lid_gap == {"left": pytest.approx(0.25)}
    # The jaw opens 4 to 5, of which 1 is left.
    assert measures.lip_gap == pytest.approx(0.2)
    np.testing.assert_allclose(measures.contact_gap, [0.25, np.nan, 0.2, np.nan])
    assert measures.inside is None


@pytest.mark.parametrize("lid", ["upper", "lower"])
def test_lids_of_which_only_the_corners_are_told_have_no_gap(neutral, templates, annotation, lid):
    few = annotation.curves | {f"eye_{lid}_left": row(4)[:2], f"mouth_inner_{lid}": row(4)[:1]}
    mesh = replace(templates.mesh, annotation=replace(annotation, curves=few))
    measures = measure_rig(neutral, templates.deltas, replace(templates, mesh=mesh))
    assert measures.lid_gap == {} and measures.lip_gap is None


def test_lips_at_any_depth_are_closed_seen_from_the_front(neutral, templates):
    deltas = lowered(neutral, 0, -1, 5, 0)
    deltas[2, row(UPPER), 2] = 3
    assert measure_rig(neutral, deltas, templates).lip_gap == pytest.approx(0, abs=1e-12)


def test_flips_are_counted_on_top_of_what_an_expression_starts_from(neutral, templates):
    measures = measure_rig(neutral, lowered(neutral, 1.5, -1, 0.5, 0), templates)
    # One strip of the eight turns over in the blink. In jawOpen the one above has no area, upside down it is in none.
    np.testing.assert_allclose(measures.flipped[[0, 2, 3]], [1 / 8, 0, 0])
    raised = measure_rig(neutral, lowered(neutral, 0, -1.5, 2, 0), templates)
    np.testing.assert_allclose(raised.flipped, [0, 1 / 8, 0, 0])


def test_strength_is_against_the_scaled_templates(neutral, templates):
    nameless = replace(templates, mesh=Mesh(neutral, templates.faces))
    measures = measure_rig(2 * neutral, 0.5 * templates.deltas, nameless)
    np.testing.assert_allclose(measures.strength, [0.25, 0.25, 0.25, np.nan])
    assert measures.lid_gap == {} and measures.lip_gap is None and measures.inside is None


def test_depth_of_lids_in_the_eyes_on_the_way(neutral, templates):
    # The nearest lid vertex is right in front of the ball, of row 4 or UPPER: row LOWER is lining.
    ball = Eyeball("left", np.array([3.0, 4, -5]), 4.0, 0.0)
    resting = measure_rig(neutral, 0 * templates.deltas, templates, [ball])
    assert resting.inside == pytest.approx(-1)
    deltas = 0 * templates.deltas
    deltas[3, row(4), 2] = -2
    assert measure_rig(neutral, deltas, templates, [ball]).inside == pytest.approx(1)
    # Half way through, and out at the other side.
    deltas[3, row(4), 2] = -10
    assert measure_rig(neutral, deltas, templates, [ball]).inside == pytest.approx(4)
    other = replace(ball, centre=np.array([3.0, 6, -4.5]))
    assert measure_rig(neutral, 0 * deltas, templates, [ball, other]).inside == pytest.approx(-0.5)
    deltas[3, row(4), 2], deltas[3, row(LOWER), 2] = 0, -4
    assert measure_rig(neutral, deltas, templates, [ball]).inside == pytest.approx(-1)


def test_names_without_lids_and_lips_have_no_gaps(neutral, faces, annotation):
    mesh = Template(neutral, faces, annotation=annotation)
    smile = ExpressionTemplates(("smile",), mesh, lowered(neutral, 1))
    measures = measure_rig(neutral, smile.deltas, smile)
    assert measures.lid_gap == {} and measures.lip_gap is None and np.isnan(measures.contact_gap).all()
    np.testing.assert_allclose(measures.strength, 1)


def test_what_does_nothing_on_top_of_an_opening_has_no_strength(neutral, faces):
    still = ExpressionTemplates(("jawOpen", "mouthClose"), Mesh(neutral, faces), lowered(neutral, -1, 0))
    with np.errstate(all="raise"):
        np.testing.assert_allclose(measure_rig(neutral, lowered(neutral, -1, 0.1), still).strength, [1, np.nan])


def test_lids_and_lips_that_are_closed_already_have_no_gap(templates, neutral):
    closed = neutral.copy()
    closed[row(UPPER), 1] = closed[row(LOWER), 1]
    with np.errstate(all="raise"):
        measures = measure_rig(closed, 0 * templates.deltas, templates)
    np.testing.assert_array_equal(measures.contact_gap, [0, np.nan, 0, np.nan])
