import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.settings import MorphableWeights
from caricli.store.models import load_model


@pytest.fixture(scope="module")
def model():
    return load_model(kind="morphable")


@pytest.fixture(scope="module")
def scene(model):
    """(latent, vertices, 81 landmarks in pixels) of a face of the model, turned by 8 degrees."""
    generator = np.random.default_rng(5)
    latent = 0.7 * generator.normal(size=len(model.basis))
    vertices = model.decode(latent)
    rotation = rotation_matrices(np.radians([[0, 8.0, 0]]))[0] @ np.diag([1.0, -1, -1])
    return latent, vertices, 1500 * vertices[model.template.annotation.landmarks] @ rotation[:2].T + [200, 210]


def test_landmarks_of_a_face_of_the_model_are_met(model, scene):
    latent, vertices, points = scene
    fit = fit_morphable(points, model)
    assert fit.nme < 1.2 and fit.prior_rms < 1 and fit.face.residual is None
    assert fit.face.latent.shape == latent.shape
    np.testing.assert_allclose(model.decode(fit.face.latent), fit.face.vertices, atol=1e-9)
    assert fit.face.camera.scale == pytest.approx(1500, rel=0.05)
    marks = model.template.annotation.landmarks
    error, before = (np.linalg.norm((v - vertices)[marks], axis=1).mean() for v in (fit.face.vertices, model.mean))
    assert error < 0.6 * before


def test_the_fit_does_not_depend_on_where_and_how_large_the_face_is(model, scene):
    fit, moved = fit_morphable(scene[2], model), fit_morphable(3 * scene[2] - 70, model)
    np.testing.assert_allclose(moved.face.latent, fit.face.latent, atol=1e-6)
    assert moved.face.camera.scale == pytest.approx(3 * fit.face.camera.scale)


def test_weights_shift_the_work_between_identity_and_expression(model, scene):
    sizes = {}
    for weights in ((1.2, 1.0), (1.2, 100.0), (100.0, 1.0), (120.0, 100.0)):
        who, what = model.parts(fit_morphable(scene[2], model, MorphableWeights(*weights)).face.latent)
        sizes[weights] = np.linalg.norm(who), np.linalg.norm(what)
    assert sizes[1.2, 100.0][1] < 0.3 * sizes[1.2, 1.0][1] and sizes[1.2, 100.0][0] > sizes[1.2, 1.0][0]
    assert sizes[100.0, 1.0][0] < 0.3 * sizes[1.2, 1.0][0] and sizes[100.0, 1.0][1] > sizes[1.2, 1.0][1]
    assert max(sizes[120.0, 100.0]) < 0.5 * max(sizes[1.2, 1.0])


def test_an_identity_that_is_given_stays(model, scene):
    latent, vertices, points = scene
    given = model.parts(latent)[0]
    fit = fit_morphable(points, model, identity=given)
    np.testing.assert_array_equal(model.parts(fit.face.latent)[0], given)
    np.testing.assert_allclose(model.decode(fit.face.latent), fit.face.vertices, atol=1e-9)
    none = fit_morphable(points, model, identity=np.zeros_like(given))
    assert not model.parts(none.face.latent)[0].any()
    errors = [np.linalg.norm(f.face.vertices - vertices, axis=1).mean() for f in (fit, none)]
    assert errors[0] < 0.6 * errors[1]
    assert fit.nme < none.nme


def test_unknown_landmarks_are_left_out(model, scene):
    points = scene[2][:68].copy()
    points[[3, 40, 60]] = np.nan
    assert fit_morphable(points, model).nme < 1.2
    with pytest.raises(InputError, match="known"):
        fit_morphable(np.where(np.arange(68)[:, None] < 63, np.nan, points), model)
