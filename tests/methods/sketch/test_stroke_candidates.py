import numpy as np

from caricli.methods.sketch.settings import NamingSettings
from caricli.methods.sketch.stroke_candidates import Candidate, StrokeShapes, stroke_costs
from caricli.structures.sketch import Stroke, StrokeKind

LIP = np.column_stack([np.linspace(100, 160, 64), np.full(64, 180.0)])


def test_a_scrap_draws_no_whole_curve_and_may_be_a_piece():
    lip = Candidate(("mouth_upper",), StrokeKind.UNKNOWN, LIP)
    costs = stroke_costs(StrokeShapes.of([Stroke(LIP[:5]), Stroke(LIP[:40])]), [lip], 150.0, NamingSettings())
    assert np.isinf(costs.whole[0, 0]) and costs.whole[1, 0] < NamingSettings.dearest
    assert np.isfinite(costs.part).all()


def test_of_no_strokes_or_candidates_none_may_be_drawn():
    lip = Candidate(("mouth_upper",), StrokeKind.FEATURE, LIP)
    for strokes, candidates in (([], [lip]), ([Stroke(LIP)], []), ([], [])):
        may_draw = StrokeShapes.of(strokes).may_draw(candidates)
        assert may_draw.shape == (len(strokes), len(candidates)) and may_draw.dtype == bool
