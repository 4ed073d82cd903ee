from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from caricli.data.identities import random_identity
from caricli.errors import InputError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.geometry.alignment.similarity import similarity
from caricli.io.bundled import asset_path
from caricli.io.strict_json import read_json
from caricli.methods.expressions.retarget_expression import (
    BoundedSystem,
    RetargetSettings,
    exchange,
    explain_landmarks,
    explain_meshes,
)
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.rig.head_expressions import head_expressions
from caricli.store.models import load_model
from caricli.structures import Camera

FRONT = np.diag([1.0, -1.0, -1.0])


@pytest.fixture(scope="module")
def model():
    return load_model(kind="morphable")


@pytest.fixture(scope="module")
def deltas(head, head_template):
    """(46, V, 3) of the default expressions."""
    templates = head_expressions(head, head_template)
    facs = read_json(asset_path("facs.json"))
    return templates.deltas[[bool(facs.get(name, {}).get("facs46")) for name in templates.names]]


@pytest.fixture(scope="module")
def people(head, head_template, deltas):
    """Five strangers in the template's size: neutral faces (5, V, 3), weights (5, 46), and what they then look like."""
    generator, face = np.random.default_rng(77), head_template.region("face")
    neutrals, weights = [], np.zeros((5, len(deltas)))
    for row in weights:
        neutral = head.evaluate(**asdict(random_identity(head, generator)))
        scale, rotation, translation = similarity(neutral[face], head_template.vertices[face])
        neutrals.append(scale * neutral @ rotation.T + translation)
        row[generator.choice(len(row), 6, replace=False)] = generator.uniform(0, 1, 6)
    neutrals = np.array(neutrals)
    return neutrals, weights, neutrals + np.tensordot(weights, deltas, 1)


def moved(vertices, seed):
    """The same face elsewhere, turned and in another size."""
    generator = np.random.default_rng(seed)
    rotation = rotation_matrices(generator.normal(size=(1, 3)))[0]
    return generator.uniform(0.5, 2) * vertices @ rotation.T + generator.normal(size=3)


def picture(vertices, model, yaw=0.0, count=68):
    """Landmarks in pixels."""
    rotation = FRONT @ rotation_matrices(np.radians([[0, yaw, 0]]))[0]
    return 1500 * vertices[model.template.annotation.landmarks[:count]] @ rotation[:2].T + [300, 310]


def shift(weights, truth, deltas):
    """How far vertices are from where they should be, and how far they should have gone; metres."""
    return [np.linalg.norm(np.tensordot(w, deltas, 1), axis=-1).mean() for w in (weights - truth, truth)]


def test_frames_share_what_a_solver_of_everything_at_once_finds():
    generator, count = np.random.default_rng(2), 4
    motions, identity, deltas = (generator.normal(size=(n, 60)) for n in (3, 5, 7))
    right = 3 * generator.normal(size=(count, 60))
    system = BoundedSystem(motions, identity, deltas, 6.0)
    frames = [system.reduced(row) for row in right]
    who = np.zeros(5)
    for _ in range(200):
        who, weights, steps = exchange(frames, who)
    # One matrix: motions of every frame, the shared five, weights of every frame; the price as part of the right side.
    eye = np.eye(count)
    rows = np.hstack([np.kron(eye, motions.T), np.kron(np.ones((count, 1)), identity.T), np.kron(eye, deltas.T)])
    squares, first = rows.T @ rows, rows.T @ right.ravel()
    squares[12:17, 12:17] += np.eye(5)
    squares[17:, 17:] += RetargetSettings.weak * np.eye(7 * count)
    first[17:] -= 6.0
    root = np.linalg.cholesky(squares).T
    low, high = np.repeat([[-np.inf, 0], [np.inf, RetargetSettings.strongest]], [17, 7 * count], axis=1)
    expected = lsq_linear(root, np.linalg.solve(root.T, first), (low, high), "bvls", max_iter=1000).x
    assert 0 < (expected[17:] == 0).sum() < 7 * count
    np.testing.assert_allclose(steps.ravel(), expected[:12], atol=1e-8)
    np.testing.assert_allclose(who, expected[12:17], atol=1e-8)
    np.testing.assert_allclose(weights.ravel(), expected[17:], atol=1e-8)


def test_weights_come_back_where_the_neutral_face_is_known(model, deltas, people):
    for seed, (neutral, truth, shape) in enumerate(zip(*people, strict=True)):
        found = explain_meshes([moved(shape, seed)], deltas, model, neutral)
        np.testing.assert_allclose(found.weights[0], truth, atol=2e-3)
        assert found.errors[0] < 1e-2
        np.testing.assert_array_equal(found.neutral, neutral)


def test_strangers_are_told_from_what_they_do(model, deltas, people):
    _, truth, shapes = people
    found = np.array([explain_meshes([shape], deltas, model).weights[0] for shape in shapes])
    wrong, whole = shift(found, truth, deltas)
    assert wrong < 0.3 * whole and np.abs(found - truth).mean() < 0.05


def test_faces_of_the_model_come_back(model, deltas, people):
    generator = np.random.default_rng(8)
    neutral = model.mean + np.tensordot(0.5 * generator.normal(size=len(model.identity)), model.identity, 1)
    truth = people[1]
    found = explain_meshes(neutral + np.tensordot(truth, deltas, 1), deltas, model)
    wrong, whole = shift(found.weights, truth, deltas)
    assert wrong < 0.1 * whole and np.abs(found.weights - truth).mean() < 0.02


def test_place_and_size_of_meshes_do_not_matter(model, deltas, people):
    shape = people[2][0]
    here, there = (explain_meshes([v], deltas, model) for v in (shape, moved(shape, 3)))
    np.testing.assert_allclose(there.weights, here.weights, atol=2e-3)
    np.testing.assert_allclose(there.neutral, here.neutral, atol=1e-4)
    np.testing.assert_allclose(there.errors, here.errors, atol=1e-2)


def test_weights_stay_within_their_bounds(model, deltas, people):
    neutral = people[0][0]
    truth = np.zeros((2, len(deltas)))
    truth[0, 3], truth[1, 5] = 2.5, -0.7
    shapes = neutral + np.tensordot(truth, deltas, 1)
    for known in (neutral, None):
        weights = explain_meshes(shapes, deltas, model, known).weights
        assert weights.min() >= 0 and weights.max() <= RetargetSettings.strongest
        assert weights[0, 3] == RetargetSettings.strongest and weights[1, 5] == 0


def test_frames_of_one_person_share_the_neutral_face(model, deltas, people):
    neutrals, truth, _ = people
    shapes = neutrals[1] + np.tensordot(truth, deltas, 1)
    together = explain_meshes(shapes, deltas, model)
    assert together.weights.shape == truth.shape and together.neutral.shape == neutrals[1].shape
    wrong, whole = shift(together.weights, truth, deltas)
    assert wrong < 0.3 * whole
    pictures = [picture(shape, model, yaw) for shape, yaw in zip(shapes, (-10, -5, 0, 5, 10), strict=True)]
    fits = [fit_morphable(points, model) for points in pictures]
    seen = explain_landmarks(fits, pictures, deltas, model)
    lone = [explain_landmarks([f], [p], deltas, model).weights[0] for f, p in zip(fits, pictures, strict=True)]
    wrong = shift(seen.weights, truth, deltas)[0]
    assert wrong < 0.5 * whole and wrong < shift(np.array(lone), truth, deltas)[0]


def test_landmarks_tell_better_than_the_expression_that_was_fitted(model, deltas, people):
    _, truth, shapes = people
    flat = deltas.reshape(len(deltas), -1)
    direct, regressed = [], []
    for shape in shapes:
        points = picture(shape, model, 6.0)
        fit = fit_morphable(points, model)
        direct.append(explain_landmarks([fit], [points], deltas, model).weights[0])
        made = np.tensordot(model.parts(fit.face.latent)[1], model.expression, 1)
        regressed.append(lsq_linear(flat.T, made.ravel(), (0, RetargetSettings.strongest)).x)
    better, worse = (shift(np.array(found), truth, deltas)[0] for found in (direct, regressed))
    assert better < worse and better < 0.7 * shift(truth, truth, deltas)[1]


def test_place_and_size_of_landmarks_do_not_matter_and_some_may_be_unknown(model, deltas, people):
    points, found = picture(people[2][0], model), []
    missing = points.copy()
    missing[[2, 40]] = np.nan
    for marks in (points, 3 * points - 500, missing):
        fit = fit_morphable(marks, model)
        found.append(explain_landmarks([fit], [marks], deltas, model))
    here, there, fewer = found
    np.testing.assert_allclose(there.weights, here.weights, atol=1e-2)
    assert there.errors[0] == pytest.approx(here.errors[0], abs=1e-2) and here.errors[0] < 1
    assert shift(fewer.weights[0], here.weights[0], deltas)[0] < 0.2 * shift(*2 * [here.weights[0]], deltas)[1]


def test_where_cameras_start_does_not_matter(model, deltas, people):
    points = picture(people[2][1], model, 4.0)
    fit = fit_morphable(points, model)
    camera = fit.face.camera
    other = Camera(
        1.04 * camera.scale, camera.rotation @ rotation_matrices(np.full((1, 3), 0.03))[0], camera.translation + 9
    )
    fits = (fit, replace(fit, face=replace(fit.face, camera=other)))
    here, there = (explain_landmarks([each], [points], deltas, model) for each in fits)
    np.testing.assert_allclose(there.weights, here.weights, atol=2e-2)
    assert there.errors[0] == pytest.approx(here.errors[0], abs=2e-2)


def test_expressions_that_move_nothing_are_refused_alone_and_left_out_among_others(model, deltas, people):
    neutrals, truth, shapes = people
    with pytest.raises(InputError, match="move a normal face"):
        explain_meshes(shapes[:1], 0 * deltas, model)
    found = explain_meshes(shapes[:1], np.concatenate([0 * deltas[:1], deltas]), model, neutrals[0])
    np.testing.assert_allclose(found.weights[0], [0, *truth[0]], atol=2e-3)
