"""Ears in pictures of heads of which everything is known."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.reconstruct.find_outline import find_outline
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.fit_landmarks_intrinsic import fit_landmarks_intrinsic
from caricli.methods.reconstruct.outline import Outline, can_find_outline
from caricli.render.sheets.overlay import overlay_mesh
from caricli.render.visibility.rasterise import rasterise
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import EAR_LEFT, EAR_RIGHT, EXTRA_NAMES
from caricli.structures.parsing import Region

EARS = [*EAR_RIGHT, *EAR_LEFT]
GIANT = {"ear-scale-incr": 1.6, "ear-wing-incr": 2.0}
BACKGROUND = (70, 110, 160)


@pytest.fixture(scope="module")
def portrait(head, intrinsic, seen):
    """A function: turn in degrees and changes of the ears to a Truth with 81 landmarks, and its picture."""

    def make(yaw=0.0, changes=GIANT):
        both = {f"{side}-{name}": weight for side in "lr" for name, weight in changes.items()}
        truth = seen(head.evaluate(changes=both), yaw=yaw, count=81)
        plain = np.full((640, 640, 3), BACKGROUND, np.uint8)
        mesh = intrinsic.template.with_vertices(truth.vertices)
        return truth, overlay_mesh(plain, mesh, truth.camera, opacity=1)

    return make


@pytest.fixture(scope="module")
def frontal(portrait, intrinsic):
    """Truth and picture of a face from the front, its fit to 68 landmarks alone, and with the picture."""
    truth, image = portrait()
    points = truth.points[:68]
    looked = fit_landmarks(points, intrinsic, picture=ParsedPicture(image))
    return truth, image, fit_landmarks(points, intrinsic), looked


def ear_errors(face, truth, intrinsic):
    """(6,) pixels."""
    ids = intrinsic.template.annotation.landmarks[EARS]
    return np.linalg.norm(face.camera.project(face.vertices[ids]) - truth.points[EARS], axis=1)


def ear_height(vertices, intrinsic, ear):
    """Metres from the top to the lobe."""
    ids = intrinsic.template.annotation.landmarks
    return np.linalg.norm(vertices[ids[ear[0]]] - vertices[ids[ear[2]]])


def test_giant_ears_come_out_of_the_picture(frontal, intrinsic):
    truth, _, alone, looked = frontal
    before = ear_errors(alone.face, truth, intrinsic).mean()
    assert ear_errors(looked.face, truth, intrinsic).mean() < 0.5 * before
    assert looked.nme < alone.nme + 0.05
    assert looked.face.landmarks.shape == (68, 2) and looked.anchors.shape == (68,)


@pytest.mark.parametrize(("yaw", "near", "far"), [(28, EAR_RIGHT, EAR_LEFT), (-28, EAR_LEFT, EAR_RIGHT)])
def test_the_far_ear_is_like_the_near_one(portrait, intrinsic, yaw, near, far):
    truth, image = portrait(yaw)
    face = fit_landmarks(truth.points[:68], intrinsic, picture=ParsedPicture(image)).face
    ratio = ear_height(face.vertices, intrinsic, far) / ear_height(face.vertices, intrinsic, near)
    assert 0.75 < ratio < 1.33
    assert ear_errors(face, truth, intrinsic).mean() < 0.06 * 620


@pytest.mark.parametrize("kind", ["plain", "noise"])
def test_a_picture_that_shows_no_ears_leaves_the_usual_ones(frontal, intrinsic, kind):
    truth, image, alone, _ = frontal
    generator = np.random.default_rng(3)
    empty = np.full_like(image, 90) if kind == "plain" else generator.integers(0, 255, image.shape).astype(np.uint8)
    looked = fit_landmarks(truth.points[:68], intrinsic, picture=ParsedPicture(empty))
    assert looked.outline.confidence[3:9].max() < 0.3
    for ear in (EAR_RIGHT, EAR_LEFT):
        usual = ear_height(alone.face.vertices, intrinsic, ear)
        assert ear_height(looked.face.vertices, intrinsic, ear) == pytest.approx(usual, rel=0.1)
    if kind == "plain":
        assert not looked.outline.found
        assert np.array_equal(looked.face.vertices, alone.face.vertices)


def test_the_forehead_follows_where_the_head_ends(head, intrinsic, seen):
    skulls = {"head-scale-vert-incr": 1.5, "forehead-scale-vert-incr": 1.0}
    for sign in (-1, 1):
        truth = seen(head.evaluate(changes={name: sign * weight for name, weight in skulls.items()}), count=81)
        plain = np.full((640, 640, 3), BACKGROUND, np.uint8)
        image = overlay_mesh(plain, intrinsic.template.with_vertices(truth.vertices), truth.camera, opacity=1)
        ids = [*intrinsic.template.annotation.landmarks[68:71], np.argmax(intrinsic.template.vertices[:, 1])]
        true = truth.camera.project(truth.vertices[ids])
        gone = []
        for picture in (None, ParsedPicture(image)):
            face = fit_landmarks(truth.points[:68], intrinsic, picture=picture).face
            gone.append(np.linalg.norm(face.camera.project(face.vertices[ids]) - true, axis=1).mean())
        assert gone[1] < 0.9 * gone[0]


def test_errors_are_those_of_the_face_whose_ears_were_fitted(head, intrinsic, seen):
    truth = seen(head.evaluate(), count=81)
    mesh = intrinsic.template.with_vertices(truth.vertices)
    owner = rasterise(truth.camera.place(mesh.vertices), mesh.faces, 640, 640).face
    ears = intrinsic.template.mask("ear_left", "ear_right")[mesh.faces].all(1)
    larger = cv2.dilate((ears[owner] & (owner >= 0)).astype(np.uint8), np.ones((15, 15), np.uint8)) > 0
    regions = np.where(owner >= 0, Region.SKIN, np.where(larger, Region.EARS, Region.BACKGROUND)).astype(np.uint8)
    regions[ears[owner] & (owner >= 0)] = Region.EARS
    image = np.full((640, 640, 3), 200, np.uint8)
    plain = fit_landmarks(truth.points, intrinsic)
    fit = fit_landmarks(truth.points, intrinsic, picture=ParsedPicture(image, regions))
    errors = 100 * np.linalg.norm(fit.face.landmarks - truth.points, axis=1)
    errors /= np.linalg.norm(np.ptp(truth.points, axis=0))
    assert fit.nme == pytest.approx(errors.mean()) and fit.nme > 2 * plain.nme
    assert fit.part_errors["extra"] == pytest.approx(errors[68:].mean())
    # Of detected ears, where it and the picture together say.
    spreads = np.tile(400.0 * np.eye(2), (81, 1, 1))
    both = fit_landmarks(truth.points, intrinsic, picture=ParsedPicture(image, regions), spreads=spreads)
    places, _ = both.outline.joined(truth.points, spreads)
    away = 100 * np.linalg.norm(both.face.landmarks - places, axis=1) / np.linalg.norm(np.ptp(places, axis=0))
    assert both.nme == pytest.approx(away.mean()) and both.nme < 2 * both.nme_latent


def test_labels_tell_ears_before_a_background_of_their_colour(head, intrinsic, seen):
    both = {f"{side}-{name}": weight for side in "lr" for name, weight in GIANT.items()}
    truth = seen(head.evaluate(changes=both), count=81)
    mesh = intrinsic.template.with_vertices(truth.vertices)
    plain = np.full((640, 640, 3), 230, np.uint8)
    skin = np.median(overlay_mesh(plain, mesh, truth.camera, opacity=1)[300:340, 280:360].reshape(-1, 3), axis=0)
    image = overlay_mesh(np.full_like(plain, np.round(skin)), mesh, truth.camera, opacity=1)
    owner = rasterise(truth.camera.place(mesh.vertices), mesh.faces, 640, 640).face
    ears = intrinsic.template.mask("ear_left", "ear_right")[mesh.faces].all(1)
    regions = np.where(owner < 0, Region.BACKGROUND, np.where(ears[owner], Region.EARS, Region.SKIN)).astype(np.uint8)
    faces = [
        fit_landmarks(truth.points[:68], intrinsic, picture=ParsedPicture(image, labels)).face
        for labels in (None, regions)
    ]
    by_colours, by_labels = (ear_errors(face, truth, intrinsic).mean() for face in faces)
    assert by_labels < 0.7 * by_colours


def test_sides_that_come_in_leave_the_lining_of_the_mouth_behind_the_skin(frontal, intrinsic, monkeypatch):
    truth, image, _, _ = frontal
    template = intrinsic.template

    def come_in(face, *_):
        vertices = np.array(face.vertices)
        vertices[template.region("inner_mouth"), 2] += 0.012
        return face.with_vertices(vertices)

    monkeypatch.setattr("caricli.methods.reconstruct.fit_sides.fit_sides", come_in)
    fit = fit_landmarks(truth.points[:68], intrinsic, picture=ParsedPicture(image))
    vertices = fit.face.vertices
    np.testing.assert_allclose(template.cavities.withdraw(vertices), vertices, atol=1e-6)
    residual = template.gradients.features(vertices) - intrinsic.features(fit.face.latent)
    np.testing.assert_allclose(fit.face.residual, residual, atol=1e-9)


def test_an_unknown_root_of_the_nose_tells_nothing_of_the_forehead(frontal, intrinsic):
    truth, image, alone, looked = frontal
    points = truth.points[:68].copy()
    points[27] = np.nan
    outline = find_outline(alone.face, intrinsic.template, points, ParsedPicture(image), np.random.default_rng(0))
    assert not outline.confidence[:3].any() and np.isnan(outline.points[:3]).all()
    assert np.allclose(outline.points[3:9], looked.outline.points[3:9], atol=15)


def test_what_is_found_is_said(frontal):
    truth, _, _, fit = frontal
    figures = fit.figures()["found_landmarks"]
    assert list(figures) == list(EXTRA_NAMES[:9])
    assert all(0 < row["confidence"] <= 1 for row in figures.values())
    assert np.allclose([row["point"] for row in figures.values()], truth.points[68:77], atol=0.05 * 620)
    assert np.array_equal(fit.shown(truth.points[:68])[EARS], fit.outline.points[3:9])


def test_the_same_picture_gives_the_same_face(frontal, intrinsic):
    truth, image, _, looked = frontal
    again = fit_landmarks(truth.points[:68], intrinsic, picture=ParsedPicture(image))
    assert np.array_equal(again.face.vertices, looked.face.vertices)


def test_size_and_place_of_the_picture_do_not_matter(frontal, intrinsic):
    truth, image, alone, looked = frontal
    large = cv2.resize(np.pad(image, ((40, 0), (70, 0), (0, 0)), mode="edge"), None, fx=2, fy=2)
    camera = alone.face.camera.zoomed(2, np.array([-70.0, -40.0]))
    points = 2 * (truth.points[:68] + [70, 40])
    face = replace(alone.face, camera=camera)
    other = find_outline(face, intrinsic.template, points, ParsedPicture(large), np.random.default_rng(0))
    assert np.allclose(other.points[3:9] / 2 - [70, 40], looked.outline.points[3:9], atol=15)


def test_given_ears_pull_as_before(frontal, intrinsic):
    truth, image, _, _ = frontal
    alone = fit_landmarks(truth.points, intrinsic)
    looked = fit_landmarks(truth.points, intrinsic, picture=ParsedPicture(image))
    assert looked.outline is None and "found_landmarks" not in looked.figures()
    assert np.array_equal(looked.face.vertices, alone.face.vertices)


def test_ears_that_stand_out_count_beside_detected_ones(frontal, intrinsic):
    truth, image, _, _ = frontal
    spreads = np.tile(400.0 * np.eye(2), (81, 1, 1))
    detected = np.array(truth.points)
    detected[EARS] += (truth.points[30] - truth.points[EARS]) * 0.15
    alone = fit_landmarks(detected, intrinsic, spreads=spreads)
    looked = fit_landmarks(detected, intrinsic, picture=ParsedPicture(image), spreads=spreads)
    assert ear_errors(looked.face, truth, intrinsic).mean() < 0.7 * ear_errors(alone.face, truth, intrinsic).mean()
    assert looked.face.landmarks.shape == (81, 2) and np.array_equal(looked.shown(detected), detected)
    assert set(looked.figures()["found_landmarks"]) == set(EXTRA_NAMES[3:9])
    empty = np.full_like(image, 90)
    same = fit_landmarks(detected, intrinsic, picture=ParsedPicture(empty), spreads=spreads)
    assert np.array_equal(same.face.vertices, alone.face.vertices)


def test_what_is_found_and_what_is_detected_count_as_they_are_sure():
    confidence = np.array([0.9, 0.9, 0.9, 0.2, 0.1, 0.1, 0.2, 0.05, 0.0, 0, 0, 0, 0])
    points = np.random.default_rng(0).uniform(0, 400, (81, 2))
    own = 0.025 * np.linalg.norm(np.ptp(points[:68], axis=0))
    places = np.where(confidence[:, None] > 0, points[68:] + own, np.nan)
    sure = Outline(places, confidence).sure_ears
    assert np.flatnonzero(sure.confidence).tolist() == [3, 4, 5]
    spreads = np.tile(own**2 * np.eye(2), (81, 1, 1))
    spreads[71] /= 10
    points[73] = spreads[73] = np.nan
    moved, doubts = sure.joined(points, spreads)
    np.testing.assert_allclose(moved[71], points[71] + own / 11)
    np.testing.assert_allclose(moved[72], points[72] + own / 2)
    np.testing.assert_allclose(moved[73], places[5])
    np.testing.assert_allclose(doubts[71:74], np.eye(2) * own**2 * np.array([1 / 11, 0.5, 1])[:, None, None])
    rest = np.delete(np.arange(81), [71, 72, 73])
    assert np.array_equal(moved[rest], points[rest]) and np.array_equal(doubts[rest], spreads[rest])
    far, _ = Outline(places + 10 * own, confidence).sure_ears.joined(points, spreads)
    assert np.array_equal(far, points, equal_nan=True)


def test_confidence_is_how_strongly_ears_pull(frontal, intrinsic):
    truth, _, usual, _ = frontal
    reached = []
    for confidence in (0.01, 0.1, 1.0):
        outline = Outline(truth.points[68:], np.where(np.isin(np.arange(68, 81), EARS), confidence, 0))
        fit = fit_landmarks_intrinsic(truth.points[:68], intrinsic, look=lambda _, outline=outline: outline)
        reached.append(ear_errors(fit.face, truth, intrinsic).mean())
    assert ear_errors(usual.face, truth, intrinsic).mean() > reached[0] > reached[1] > reached[2]


def test_inside_a_model_too(frontal, pca):
    truth, image, _, _ = frontal
    alone = fit_landmarks(truth.points[:68], pca, "latent")
    looked = fit_landmarks(truth.points[:68], pca, "latent", picture=ParsedPicture(image))
    assert ear_errors(looked.face, truth, pca).mean() < 0.8 * ear_errors(alone.face, truth, pca).mean()
    assert (alone.rounds, looked.rounds) == (10, 20)


def test_where_nothing_can_be_found(frontal, intrinsic):
    truth, _, _, _ = frontal
    points = truth.points[:68]
    template = intrinsic.template
    assert can_find_outline(points, template)
    assert not can_find_outline(truth.points, template)
    spreads = np.tile(np.eye(2), (81, 1, 1))
    assert can_find_outline(truth.points, template, spreads)
    assert not can_find_outline(truth.points / 20, template, spreads)
    assert not can_find_outline(np.where(np.arange(68)[:, None] == 3, np.nan, points), template)
    note = template.annotation
    bare = replace(note, curves={name: line for name, line in note.curves.items() if name != "ear_left"})
    assert not can_find_outline(points, replace_annotation(template, bare))
    assert not can_find_outline(points, replace_annotation(template, replace(note, landmarks=note.landmarks[:68])))


def replace_annotation(template, note):
    """A stand-in for a template with another annotation."""
    return type("Bare", (), {"annotation": note, "vertices": template.vertices})


def test_landmarks_outside_the_picture_are_refused(frontal, intrinsic):
    truth, image, fit, _ = frontal
    with pytest.raises(InputError, match="found them outside"):
        far = truth.points[:68] + 5000
        find_outline(fit.face, intrinsic.template, far, ParsedPicture(image), np.random.default_rng(0))


def test_where_hair_may_hide_the_upper_part_of_an_ear_what_is_seen_of_it_counts_little(frontal, intrinsic):
    truth, image, alone, _ = frontal
    image = image.copy()
    regions = np.full(image.shape[:2], Region.SKIN, np.uint8)
    for ear in (EAR_RIGHT, EAR_LEFT):
        (left, top), (right, bottom) = (
            np.rint(f(truth.points[list(ear)], axis=0)).astype(int) for f in (np.min, np.max)
        )
        hidden = np.s_[top - 40 : (top + bottom) // 2, left - 40 : right + 40]
        image[hidden] = BACKGROUND
        regions[hidden] = Region.HAIR
    beside = np.where(regions == Region.HAIR, Region.BACKGROUND, regions).astype(np.uint8)
    hair, wall = (
        find_outline(
            alone.face, intrinsic.template, truth.points[:68], ParsedPicture(image, labels), np.random.default_rng(0)
        )
        for labels in (regions, beside)
    )
    assert wall.confidence[3:9].max() > 0.2
    assert hair.confidence[3:9].max() < 0.5 * wall.confidence[3:9].max()
