from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from caricli.data import build_dataset as building
from caricli.data.build_dataset import build_dataset
from caricli.data.build_settings import BuildSettings
from caricli.data.dataset import read_dataset
from caricli.data.unseen import unseen_data
from caricli.methods.evaluate.evaluate_landmark_map import (
    NEAREST,
    FacePairs,
    components,
    draws,
    error_figures,
    evaluate_landmark_map,
    face_errors,
    face_pairs,
    measure_landmark_map,
    regression,
    spread,
    true_spread,
)
from caricli.methods.train.see_faces import map_faces
from caricli.models.landmark_map.model import DOMAINS
from caricli.store.landmark_maps import load_landmark_map


@pytest.fixture
def faces():
    return np.random.default_rng(0).normal(size=(400, 68, 2))


def test_errors_are_shares_of_the_diagonal(faces):
    true = faces[:2]
    diagonals = np.linalg.norm(np.ptp(true, axis=1), axis=1)
    found = true + [0.0, 1.0] * diagonals[:, None, None] / 50
    np.testing.assert_allclose(face_errors(found, true), 2)
    np.testing.assert_allclose(face_errors(np.stack([found, true]), true), [[2, 2], [0, 0]], atol=1e-12)


def test_the_interval_is_that_of_people_not_of_faces():
    """Two people, one of whom a rival helps and the other not: the interval holds both extremes."""
    people = np.repeat([7, 9], 100)
    errors = np.repeat([1.0, 2.0], 100)
    figures = error_figures(errors, np.full(200, 2.0), people)
    assert figures == {"error": 1.5, "below_identity": 25, "low": 0, "high": 50}
    alike = error_figures(np.tile([1.0, 2.0], 100), np.full(200, 2.0), people)
    assert alike["low"] == alike["high"] == 25


def test_draws_vary_as_the_parts_say(faces):
    parts = np.random.default_rng(1).normal(size=(2, 136))
    drawn = (draws(faces, parts) - faces).reshape(-1, 136)
    assert len(drawn) == NEAREST * len(faces)
    np.testing.assert_allclose(np.cov(drawn.T), parts.T @ parts, atol=0.4)
    found = components(drawn.reshape(-1, 68, 2), 2)
    np.testing.assert_allclose(found.T @ found, parts.T @ parts, atol=0.4)


def test_the_spread_is_the_distance_of_two_draws(faces):
    drawn = np.stack([faces, faces + [0.0, 1.0], faces])
    assert spread(drawn, faces) == pytest.approx(face_errors(faces + [0.0, 1.0], faces).mean())


def test_regression_finds_a_linear_map(faces):
    def turned(points):
        return 2 * points[..., ::-1] + 1

    found = regression(faces, turned(faces))(faces[:5])
    np.testing.assert_allclose(found, turned(faces[:5]), atol=0.15)


def test_rivals_learn_from_the_training_alone(faces):
    """Caricatures are twice as large as faces in the training and three times in the test."""
    training = FacePairs(faces, 2 * faces, np.arange(400))
    normal = faces[:20] + np.random.default_rng(2).normal(0, 0.1, (20, 68, 2))
    pairs = FacePairs(normal, 3 * normal, np.arange(20))
    flat = np.zeros(136)
    still: Any = SimpleNamespace(
        map_aligned=lambda points, to, style=None: points,
        own_style=lambda face: None, styles=np.zeros((3, 136)), normal=flat, caricature=flat,
    )  # fmt: skip
    figures = measure_landmark_map(still, pairs, training)
    half = face_errors(1.5 * normal, normal).mean()
    assert figures["normal"]["paired regression"]["error"] == pytest.approx(half, rel=0.1)
    twice = face_errors(2 * normal, 3 * normal).mean()
    # Nothing is left to draw of what is linear.
    for name in ("paired regression", "paired regression with draws"):
        assert figures["caricature"][name]["error"] == pytest.approx(twice, rel=0.1)
    nearest = face_errors(np.stack([2 * faces[:20]]), 3 * normal).mean()
    assert figures["caricature"]["random caricatures"]["error"] > nearest
    assert figures["caricature"]["mean"]["error"] == pytest.approx(face_errors(0 * normal, 3 * normal).mean())
    assert true_spread(pairs) > 0.5 * figures["normal"]["identity"]["error"]


def test_what_was_learnt_from_is_not_measured(monkeypatch):
    room = "caricli.methods.evaluate.evaluate_landmark_map."
    monkeypatch.setattr(room + "has_partners", lambda data: True)
    monkeypatch.setattr(room + "face_pairs", lambda faces, part: part)
    monkeypatch.setattr(room + "measure_landmark_map", lambda model, pairs, training: (pairs, training))
    rows = {part: {"normal": [1], "caricature": [2, 3]} for part in ("training", "held out", "test")}
    rows["held out"]["caricature"] = []
    faces: Any = SimpleNamespace(data=None, rows=rows)
    model: Any = None
    found = evaluate_landmark_map(model, faces)
    assert found["error"] == {"test": ("test", "training")}
    assert found["meshes"]["test"] == {"normal": 1, "caricature": 2}


@pytest.fixture(scope="module")
def strangers(tmp_path_factory):
    """Caricatures of people whom no training saw, beside the faces that they were made of."""
    folder = tmp_path_factory.mktemp("strangers")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(building, "PRIOR_SHAPES", 16)
        patch.setattr(building, "PRIOR_DIMENSION", 8)
        build_dataset(folder, BuildSettings(count=20, identities=20, seed=260022), 1)
    people = unseen_data(read_dataset(folder), {"map": load_landmark_map().seen}, everyone=True)
    return face_pairs(map_faces(people.data, 4, 0), "test")


def test_the_bundled_map_is_nearer_to_strangers_than_no_map(strangers):
    figures = measure_landmark_map(load_landmark_map(), strangers, strangers)
    least = {"normal": 25, "caricature": 10}
    for to in DOMAINS:
        own = figures[to]["map"]
        assert own["below_identity"] > least[to] and own["low"] > 0
        assert own["error"] < figures[to]["mean"]["error"]
    assert figures["caricature"]["map"]["error"] < figures["caricature"]["random caricatures"]["error"]
