from dataclasses import replace

import numpy as np
import pytest

from caricli.geometry.deformation_gradients import rotation_matrices
from caricli.methods.evaluate.evaluate_portrait import (
    ADJUSTED,
    COARSE,
    METHODS,
    PAPER_SIDE,
    REFINED,
    PortraitStudio,
    Reconstruction,
    mean_figures,
    measure_portrait,
    reconstruct_portrait,
    refinement_gains,
)
from caricli.render.rasterise import rasterise

SIZE = 128


@pytest.fixture(scope="module")
def studio(head_template):
    return PortraitStudio(head_template, SIZE)


@pytest.fixture(scope="module")
def portrait(studio, strangers):
    return studio.portray("someone", strangers[1], np.random.default_rng(4))


@pytest.fixture(scope="module")
def models():
    from caricli.store.models import load_model

    return {kind: load_model(kind=kind) for kind, *_ in COARSE.values()}


def test_a_portrait_shows_the_face_where_its_pose_and_mask_say(portrait, head_template):
    placed = portrait.pose.scale * portrait.truth @ portrait.pose.rotation.T + [*portrait.pose.translation, 0]
    silhouette = rasterise(placed, head_template.faces, SIZE, SIZE).face >= 0
    # Lids leave out the eyeballs, and borders are coverage here and centres of pixels there.
    assert (silhouette != portrait.mask).mean() < 0.02
    assert 0.05 < portrait.mask.mean() < 0.8
    assert np.linalg.det(portrait.pose.rotation) == pytest.approx(1)
    note = head_template.annotation
    wanted = portrait.pose.project(portrait.truth[note.landmarks[17:68]])
    assert portrait.points.shape == (68, 2) and np.allclose(portrait.points[17:], wanted)
    assert ((portrait.points > 0) & (portrait.points < SIZE)).all()


def test_the_seed_makes_picture_and_noise(studio, strangers, portrait):
    again = studio.portray("someone", strangers[1], np.random.default_rng(4))
    assert np.array_equal(again.image, portrait.image) and np.array_equal(again.points, portrait.points)
    noisy = studio.portray("someone", strangers[1], np.random.default_rng(4), noise=2.0)
    offset = (noisy.points - portrait.points) / np.linalg.norm(np.ptp(portrait.points, axis=0))
    assert np.std(offset) == pytest.approx(0.02, rel=0.2)
    other = studio.portray("someone", strangers[1], np.random.default_rng(5))
    assert not np.array_equal(other.image, portrait.image)


def test_background_is_not_of_the_head(studio, strangers):
    """Half of the backgrounds are plain, and the rest are not."""
    spreads = []
    for seed in range(4):
        portrait = studio.portray("someone", strangers[0], np.random.default_rng(seed))
        # Pixels on the outline are mixtures.
        rows, columns = np.nonzero(~portrait.mask)
        far = (columns < 4) | (columns >= SIZE - 4)
        spreads.append(portrait.image[rows[far], columns[far]].astype(float).std(0).max())
    assert min(spreads) < 1e-9 and max(spreads) > 5


def test_refining_beats_every_rival_at_the_landmarks(portrait, models):
    found, refused = reconstruct_portrait(portrait.points, models)
    assert tuple(found) == METHODS and not refused
    for name in COARSE:
        # The elastic fit may be as near as that by itself.
        assert found[name + REFINED].errors["all"] < max(0.1, found[name].errors["all"] / 5)
        assert found[name + REFINED].seconds > found[name].seconds
        for key in (name, name + REFINED):
            projected = found[key].pose.project(found[key].vertices)
            nearest = np.linalg.norm(projected[:, None] - found[key].landmarks, axis=2).min(0)
            assert nearest.max() < 1e-6
    exp, both = (found[name].errors["all"] for name in ADJUSTED)
    # Adjusting more coefficients, and with less regularisation, comes nearer, but not as near.
    assert found["morphable" + REFINED].errors["all"] < both < exp
    assert both < found["morphable"].errors["all"]


def test_a_refinement_that_is_refused_leaves_the_others(portrait, models, monkeypatch):
    monkeypatch.setattr("caricli.methods.evaluate.evaluate_portrait.COARSE", {"morphable": COARSE["morphable"]})
    points = portrait.points.copy()
    middle = points[48:68].mean(0)
    points[[61, 62, 63, 65, 66, 67]] = 2 * middle - points[[61, 62, 63, 65, 66, 67]] + [0, 3]
    points[[61, 62, 63]] += [0, 0.1 * SIZE]
    found, refused = reconstruct_portrait(points, models)
    assert list(found) == ["morphable", *ADJUSTED]
    assert list(refused) == ["morphable" + REFINED] and "crossed" in refused["morphable" + REFINED]


def test_3d_error_is_of_the_face_and_free_of_similarities(portrait, head_template):
    errors = {"eyes": 0.5, "all": 1.0}
    turn = rotation_matrices(np.radians([[10.0, 40, 5]]))[0]
    exact = 1.3 * portrait.truth @ turn.T + [0.1, 0.2, 0.3]
    face = np.isin(np.arange(len(exact)), head_template.region("face"))
    exact[~face] += 1.0
    found = Reconstruction(exact, portrait.pose, portrait.points, errors, 0.001, 2.0)
    figures = measure_portrait(found, portrait, head_template)
    assert figures["shape"] < 1e-9 and figures["flipped"] == pytest.approx(0.1) and figures["seconds"] == 2.0
    bumpy = portrait.truth + 0.002 * np.where(np.arange(len(exact)) % 2, 1, -1)[:, None] * [0, 0, 1]
    share = measure_portrait(replace(found, vertices=bumpy), portrait, head_template)["shape"]
    assert share == pytest.approx(100 * 0.002 / np.ptp(portrait.truth[:, 1]), rel=0.05)
    assert "shape" not in measure_portrait(found, replace(portrait, truth=None), head_template)


def test_pixels_are_summed_over_known_landmarks_in_a_picture_of_the_papers_size(portrait, head_template):
    points = portrait.points.copy()
    points[40] = np.nan
    found = Reconstruction(portrait.truth, portrait.pose, points, {"eyes": 2.0, "all": 1.0}, 0.0, 0.0)
    figures = measure_portrait(found, replace(portrait, points=points), head_template)
    diagonal = np.linalg.norm(np.nanmax(points, axis=0) - np.nanmin(points, axis=0)) * PAPER_SIDE / SIZE
    assert figures["pixels"] == pytest.approx({"eyes": 11 * 0.02 * diagonal, "all": 67 * 0.01 * diagonal})


def test_means_and_gains_take_the_faces_that_have_figures():
    name, fine = "elastic", "elastic" + REFINED
    faces = [
        {name: {"shape": 2.0, "nme": {"all": 1.0}}, fine: {"shape": 1.0, "nme": {"all": 0.5, "eyes": 3.0}}},
        {name: {"shape": 4.0, "nme": {"all": 2.0}}, fine: {"shape": 5.0, "nme": {"all": 0.1}}},
        {name: {"shape": 9.0, "nme": {"all": 3.0}}},
    ]
    means = mean_figures(faces)
    assert means == {
        name: {"shape": 5.0, "nme": {"all": 2.0}},
        fine: {"shape": 3.0, "nme": {"all": pytest.approx(0.3), "eyes": 3.0}},
    }
    assert refinement_gains(faces) == {name: {"faces": 2, "better": 1, "before": 3.0, "after": 3.0}}
