from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.lines.match_line import resample
from caricli.limits import MAX_SKETCH_POINTS
from caricli.methods.faces.encode_face import decode_face
from caricli.methods.faces.encode_landmarks import landmark_encoder
from caricli.methods.sketch import reconstruct_sketch
from caricli.methods.sketch.model_coarse import CoarseFace, model_coarse
from caricli.methods.sketch.reconstruct_sketch import SketchReconstruction
from caricli.methods.sketch.settings import FollowSettings
from caricli.store.models import load_model
from caricli.store.session_tools import SessionTools
from caricli.structures.sketch import Sketch, Stroke, StrokeKind


@pytest.fixture(scope="module")
def coarse(model):
    return partial(model_coarse, encoder=landmark_encoder(model, load_model()))


@pytest.fixture(scope="module")
def reconstruction(model, coarse):
    return SketchReconstruction(model, coarse)


@pytest.fixture(scope="module")
def own():
    """As the page reconstructs."""
    return SessionTools().reconstruction


def test_lines_are_followed_and_what_the_latent_cannot_say_is_kept(reconstruction, model, sketch):
    fit = reconstruction.reconstruct(sketch)
    assert fit.errors["all"] < 0.1 < 2 * fit.coarse["all"]
    assert fit.flipped < 1e-3
    assert set(fit.errors) == {curve.name for curve in reconstruction.handles.curves} | {"all"}
    np.testing.assert_allclose(decode_face(fit.face, model, fit.face.shift).vertices, fit.face.vertices, atol=1e-6)
    marks = fit.face.camera.project(fit.face.vertices[model.template.annotation.landmarks])
    np.testing.assert_allclose(fit.face.landmarks, marks)


def test_following_goes_as_far_as_it_is_asked(reconstruction, sketch):
    fits = [reconstruction.reconstruct(sketch, share) for share in (0, 0.5)]
    assert fits[0].errors == fits[0].coarse == fits[1].coarse
    assert fits[1].errors["all"] < 0.7 * fits[1].coarse["all"]


def test_lines_from_which_following_leads_away_are_doubtful(reconstruction, sketch):
    fit = reconstruction.reconstruct(sketch)
    assert "doubtful" not in fit.describe()
    assert "took the face farther from them" in replace(fit, errors={"all": 2 * fit.coarse["all"]}).describe()


def test_a_redrawn_mouth_moves_the_mouth(reconstruction, sketch):
    def wide(stroke):
        if stroke.curve is None or not stroke.curve.startswith("mouth"):
            return stroke
        middle = stroke.points.mean(0)
        return stroke.moved((stroke.points - middle) * [1.3, 1] + middle)

    faces = [reconstruction.reconstruct(each).face for each in (sketch, sketch.with_strokes(map(wide, sketch.strokes)))]
    corners = reconstruction.model.template.annotation.landmarks[[48, 54]]
    widths = [np.ptp(face.camera.project(face.vertices[corners])[:, 0]) for face in faces]
    assert widths[1] / widths[0] == pytest.approx(1.3, abs=0.03)


def test_a_name_that_no_curve_has_is_no_line_of_it(reconstruction, sketch):
    other = Stroke(np.array([[10.0, 10], [60, 60]]), curve="moustache")
    fit = reconstruction.reconstruct(Sketch((*sketch.strokes, other)))
    assert fit.sketch.strokes[-1].curve is None and "moustache" not in fit.errors


def test_an_empty_canvas_is_refused(reconstruction):
    with pytest.raises(InputError, match="expected lines of the curves of a face, found none"):
        reconstruction.reconstruct(Sketch())


def test_lines_that_would_tear_the_surface_are_followed_less_far(model, coarse, sketch):
    def fallen(stroke):
        if stroke.curve is None or not stroke.curve.startswith("brow"):
            return stroke
        return stroke.moved(stroke.points + [0, 130])

    careful = SketchReconstruction(model, coarse, settings=FollowSettings(torn=0.001))
    fit = careful.reconstruct(sketch.with_strokes(map(fallen, sketch.strokes)))
    assert 0 < fit.share < fit.asked == 1 and fit.flipped <= 0.001
    assert "the surface would tear" in fit.describe() and fit.figures()["followed"] == fit.share


def test_lines_whose_likeliest_face_is_torn_are_refused(model, coarse, sketch):
    def torn(*_):
        face, name = coarse(*_)
        generator = np.random.default_rng(1)
        return CoarseFace(face.with_vertices(face.vertices + generator.normal(0, 0.1, face.vertices.shape)), name)

    with pytest.raises(InputError, match="expected lines that a face could show, found the likeliest one torn"):
        SketchReconstruction(model, torn, settings=FollowSettings(torn=0.0)).reconstruct(sketch, 0.0)
    # Within what is allowed it is smoothed until it is sound.
    assert SketchReconstruction(model, torn).reconstruct(sketch, 0.0).flipped <= FollowSettings().torn


def _arc(x, y, wide, high, turns=(0, 1)):
    angles = np.linspace(2 * np.pi * turns[0], 2 * np.pi * turns[1], 40)
    return np.column_stack([x + wide * np.cos(angles), y + high * np.sin(angles)])


def test_a_cat_is_doubtful_and_whole(reconstruction, sketch):
    lines = [
        *(_arc(128, 140, 80, 70), _arc(98, 125, 14, 18), _arc(158, 125, 14, 18), _arc(98, 125, 3, 14)),
        *(_arc(158, 125, 3, 14), _arc(118, 170, 10, 8, (0, 0.5)), _arc(138, 170, 10, 8, (0, 0.5))),
        *(np.array(ear, float) for ear in ([[60, 105], [50, 30], [105, 75]], [[150, 75], [205, 30], [196, 105]])),
        np.array([[118.0, 155], [138, 155], [128, 165], [118, 155]]),
        *(np.array([[128 + side * 28, 165 + 4 * k], [128 + side * 88, 160 + 14.0 * k]])
          for side in (-1, 1) for k in (-1, 0, 1)),
    ]  # fmt: skip
    fit = reconstruction.reconstruct(Sketch(tuple(map(Stroke, lines))))
    assert fit.unsure > 0.5 and "% of the strokes without a name are no lines of a face" in fit.describe()
    assert np.isfinite(fit.face.vertices).all() and fit.flipped <= FollowSettings().torn
    assert fit.figures()["unsure"] == fit.unsure
    assert reconstruction.reconstruct(sketch).unsure == 0


def test_scribble_is_refused(reconstruction):
    generator = np.random.default_rng(3)
    walks = (generator.normal(0, 8, (30, 2)).cumsum(0) + generator.uniform(60, 200, 2) for _ in range(12))
    with pytest.raises(InputError, match="expected lines"):
        reconstruction.reconstruct(Sketch(tuple(map(Stroke, walks))))


def test_scribble_is_refused_when_what_contradicts_it_is_left(own):
    generator = np.random.default_rng(24)
    count = generator.integers(8, 20)
    walks = [generator.normal(0, 8, (30, 2)).cumsum(0) + generator.uniform(60, 200, 2) for _ in range(count)]
    with pytest.raises(InputError, match="found most of them none of it and the others tearing it apart"):
        own.reconstruct(Sketch(tuple(map(Stroke, walks))))


DRAWN = [
    [(256, 61), (375, 157), (390, 240), (379, 321), (330, 390), (256, 420), (180, 390), (133, 324), (120, 240)],
    [(122, 200), (102, 200), (94, 219), (92, 238), (94, 253), (100, 273), (122, 276)],
    [(389, 200), (409, 200), (417, 219), (419, 238), (417, 253), (411, 273), (389, 276)],
    [(161, 176), (169, 169), (180, 159), (194, 157), (206, 158), (219, 164), (232, 171)],
    [(279, 171), (289, 166), (302, 158), (317, 157), (328, 156), (339, 166), (350, 176)],
    [(168, 207), (172, 200), (182, 195), (196, 193), (203, 193), (216, 197), (224, 207)],
    [(168, 207), (172, 213), (182, 218), (196, 219), (203, 219), (216, 216), (224, 207)],
    [(287, 207), (290, 200), (301, 195), (315, 193), (322, 193), (335, 197), (343, 207)],
    [(287, 207), (290, 213), (301, 218), (315, 219), (322, 219), (335, 216), (343, 207)],
    [(243, 216), (240, 239), (234, 265), (222, 286), (221, 302), (229, 310), (241, 307)],
    [(241, 307), (244, 310), (250, 315), (256, 318), (259, 316), (265, 311), (270, 307)],
    [(268, 216), (271, 239), (277, 265), (289, 286), (290, 302), (282, 310), (270, 307)],
    [(192, 362), (213, 354), (235, 350), (256, 355), (273, 351), (293, 352), (319, 362)],
    [(192, 362), (211, 363), (233, 365), (256, 366), (273, 365), (296, 364), (319, 362)],
    [(192, 362), (210, 378), (231, 390), (256, 392), (276, 391), (297, 381), (319, 362)],
]  # fmt: skip
"""A plain face whose nose is of three strokes: its sides, of which heads have no curves, and the line between."""
CREASE = np.array([(230.0, 402), (256, 398), (282, 402)])
"""Under its mouth."""


def plain_face(*more):
    """The strokes of a plain face, and more lines."""
    first, *lines = [np.array(line, float) for line in DRAWN]
    return [Stroke(resample(line, 30)) for line in (np.concatenate([first, first[:1]]), *lines, *more)]


def test_sides_of_a_nose_leave_its_bridge_in_the_middle(own):
    fit = own.reconstruct(Sketch(tuple(plain_face()), (512, 512)))
    assert not fit.left and fit.errors["all"] < 0.1 and fit.flipped < 1e-3
    # Of its sides the wings are read as parts of the nose.
    assert [stroke.curve for stroke in fit.sketch.strokes][9:] == [
        None, "nose", "nose", None, "nose", "mouth_upper", "mouth_inner_upper", "mouth_lower",
    ]  # fmt: skip
    bridge, face = fit.curves["nose_bridge"][:, 0], fit.curves["silhouette"][:, 0]
    assert np.abs(bridge - (face.min() + face.max()) / 2).max() < 0.03 * np.ptp(face)


def test_strokes_that_go_with_no_others_do_not_tear_the_face(own, monkeypatch):
    sketch = Sketch(tuple(plain_face(CREASE)), (512, 512))
    fit = own.reconstruct(sketch)
    assert fit.flipped < 1e-3 and fit.errors["all"] < 0.2
    assert fit.left and "goes with no other line" in fit.describe()
    monkeypatch.setattr(reconstruct_sketch, "_ROUNDS", 0)
    assert own.reconstruct(sketch).errors["all"] > 1.5 * fit.errors["all"]


def test_a_small_drawing_on_a_large_page_is_doubted_as_a_large_one(own):
    strokes = plain_face(CREASE)
    # All but the outline are shorter on the page than what draws a curve of a face that fills it.
    large, small = (
        own.reconstruct(Sketch(tuple(stroke.moved(stroke.points / zoom + 40) for stroke in strokes), (700, 700)))
        for zoom in (2, 24)
    )
    assert large.left and small.left == large.left
    assert [s.curve for s in small.sketch.strokes] == [s.curve for s in large.sketch.strokes]
    assert large.scale == pytest.approx(12 * small.scale, rel=1e-3) and small.scale < 0.05
    assert small.errors["all"] / small.scale == pytest.approx(large.errors["all"] / large.scale, rel=0.02)
    assert replace(small, coarse={"all": 1.0}).strange and not replace(large, coarse={"all": 1.0}).strange


def test_lines_that_leave_the_canvas_far_behind_are_compared_at_few_points():
    far = np.array([[-1e6, 0], [1e6, 0], [-1e6, 9], [1e6, 9]])
    distances = reconstruct_sketch._distances({"nose": [far]}, {"nose": np.zeros((1, 2))}, 256)["nose"]
    assert 1000 < len(distances) <= MAX_SKETCH_POINTS and distances.max() == pytest.approx(1e8 / 256)


def test_where_too_little_is_left_the_fit_with_all_of_it_stays(own, monkeypatch):
    sketch = Sketch(tuple(plain_face(CREASE)), (512, 512))
    monkeypatch.setattr(reconstruct_sketch, "_without", lambda named, curve, sketch: sketch)
    fit = own.reconstruct(sketch)
    assert not fit.left and len(fit.sketch.strokes) >= len(sketch.strokes)


def test_strokes_that_are_left_are_of_the_kind_that_they_were():
    line = np.column_stack([np.linspace(0, 200, 9), np.full(9, 60.0)])
    drawn = Sketch((Stroke(line, StrokeKind.FEATURE), Stroke(line + [0, 40])))
    pieces = (Stroke(line[:5], StrokeKind.SILHOUETTE, "nose"), Stroke(line[4:], StrokeKind.WRINKLE, "brow_left"))
    left = reconstruct_sketch._without(drawn.with_strokes(pieces), "nose", drawn)
    assert [(stroke.curve, stroke.kind) for stroke in left.strokes] == [(None, "feature"), ("brow_left", "wrinkle")]


def test_strokes_that_share_ends_are_left_of_their_own_kinds():
    outline = Stroke(np.array([[0.0, 0], [9, 0], [9, 9], [0, 9]]), StrokeKind.SILHOUETTE)
    line = Stroke(outline.points[[0, 3]], StrokeKind.FEATURE)
    other = Stroke(np.array([[0.0, 0], [5, 5], [7, 5]]), StrokeKind.UNKNOWN)
    strange = Stroke(outline.points + 0.5, StrokeKind.WRINKLE)
    for strokes in ((line, other, outline), (outline, other, line)):
        named = Sketch(tuple(replace(stroke, curve="nose") for stroke in (*strokes, strange)))
        left = reconstruct_sketch._without(named, "nose", Sketch(strokes))
        assert [stroke.kind for stroke in left.strokes] == [*(stroke.kind for stroke in strokes), StrokeKind.UNKNOWN]
