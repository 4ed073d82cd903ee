import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.methods.morphable.coefficients import CoefficientLayout, turned_light
from caricli.methods.morphable.renderer import MorphableRenderer
from caricli.methods.reconstruct.fit_coarse import _filled, fit_coarse, see_coarse
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.train.coarse.train_coarse import new_coarse_network
from caricli.models.coarse.config import CoarseConfig
from caricli.models.coarse.model import SHARE, CoarseModel
from caricli.store.models import load_morphable
from caricli.structures.detection import FaceFrame

IMAGE = np.zeros((200, 220, 3), np.uint8)


@pytest.fixture(scope="module")
def model():
    return load_morphable()


@pytest.fixture(scope="module")
def truth(model):
    """(coefficients of somebody in a picture, its landmarks (68, 2))."""
    layout = CoefficientLayout.of(model)
    x = np.zeros(layout.size)
    x[: layout.shape] = np.random.default_rng(0).normal(0, 0.7, layout.shape)
    layout.parts(x)["light"][:] = np.random.default_rng(1).normal(size=9)
    layout.parts(x)["pose"][:] = [0.1, 0.25, -0.2, 105, 98, 400]
    renderer = MorphableRenderer(model, torch.float64)
    posed = renderer.pose(torch.from_numpy(x)[None])
    return x, renderer.landmarks(posed, renderer.anchors(posed, 68))[0].numpy()


def sure(model, value, points):
    """A network that says of every window that it shows a face of these coefficients, as it sees it."""
    config = CoarseConfig(size=64)
    network = new_coarse_network(config, model, torch.Generator().manual_seed(0))
    matrix = FaceFrame.of(points).matrix(64, SHARE)
    told = value.copy()
    parts = CoefficientLayout.of(model).parts(told)
    parts["light"][:] = turned_light(parts["light"], -FaceFrame.of(points).roll)
    pose = parts["pose"]
    scale = np.sqrt(np.linalg.det(matrix[:, :2]))
    pose[2] -= FaceFrame.of(points).roll
    pose[3:5] = matrix[:, :2] @ pose[3:5] + matrix[:, 2]
    pose[5] *= scale
    network.start.copy_(torch.from_numpy(told))
    return CoarseModel(network, 64, model.model_id)


def error(model, latent, truth):
    return np.linalg.norm(model.decode(latent) - model.decode(truth[:144]), axis=1).mean()


def test_what_the_network_says_of_a_window_is_true_of_the_picture(model, truth):
    value, points = truth
    sight = see_coarse(points, IMAGE, sure(model, value, points), model)
    np.testing.assert_allclose(sight.coefficients, value, atol=1e-4)
    vertices = model.decode(sight.coefficients[:144])
    landmarks = sight.camera.project(vertices[model.template.annotation.landmarks[17:68]])
    np.testing.assert_allclose(landmarks, points[17:], atol=0.1)


def test_alone_its_word_is_the_face(model, truth):
    value, points = truth
    fit = fit_coarse(points, model, sure(model, value, points), IMAGE, alone=True)
    np.testing.assert_allclose(fit.face.latent, value[:144], atol=1e-5)
    assert fit.nme < 0.1 and fit.figures()["coefficients"]["pose"][5] == pytest.approx(400, rel=1e-3)
    np.testing.assert_allclose(fit.coefficients["pose"][3:5], [105, 98], atol=0.1)


def test_landmarks_correct_it_as_far_as_it_is_usually_wrong(model, truth):
    value, points = truth
    wrong = value.copy()
    wrong[:144] += np.random.default_rng(1).normal(0, 0.3, 144)
    network = sure(model, wrong, points)
    network.network.doubt[:144] = 0.3
    alone = fit_coarse(points, model, network, IMAGE, alone=True)
    near = fit_coarse(points, model, network, IMAGE)
    from_afar = fit_morphable(points, model)
    assert near.nme < alone.nme
    assert error(model, near.face.latent, value) < error(model, alone.face.latent, value)
    assert error(model, near.face.latent, value) < error(model, from_afar.face.latent, value)
    network.network.doubt[:144] = 1e-4
    certain = fit_coarse(points, model, network, IMAGE)
    np.testing.assert_allclose(certain.face.latent, wrong[:144], atol=1e-3)


def test_landmarks_that_are_not_known_leave_the_frame_where_it_is(model, truth):
    value, points = truth
    fewer = points.copy()
    fewer[[0, 1, 8, 30]] = np.nan
    fit = fit_coarse(fewer, model, sure(model, value, points), IMAGE)
    assert np.linalg.norm(fit.face.landmarks - points, axis=1).max() < 6
    with pytest.raises(InputError, match="known landmarks"):
        fit_coarse(np.full((68, 2), np.nan), model, sure(model, value, points), IMAGE)
    with pytest.raises(InputError, match="found landmarks without one"):
        fit_coarse(points, model, sure(model, value, points), None)


def test_what_is_not_known_is_not_mirrored(model):
    """Brows that frown, alone, are more like the mean's upside down."""
    front = model.mean[model.template.annotation.landmarks[:68], :2] * [1, -1]
    points = np.full((68, 2), np.nan)
    points[17:27] = front[17:27]
    points[17:27, 1] = 2 * front[17:27, 1].mean() - front[17:27, 1]
    filled = _filled(points, model)
    np.testing.assert_array_equal(filled[17:27], points[17:27])
    assert filled[8, 1] > filled[27, 1] + 0.1 and filled[36, 0] < filled[45, 0] - 0.05
