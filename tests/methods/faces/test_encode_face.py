import numpy as np
import pytest

from caricli.methods.evaluate.evaluate_shape import evaluate_shape
from caricli.methods.faces.encode_face import decode_face, encode_face


@pytest.fixture(params=["pca", "intrinsic"])
def model(request):
    return request.getfixturevalue(request.param)


def test_latent_residual_and_shift_give_the_very_face_back(model, strangers):
    for vertices in strangers[:3]:
        code = encode_face(vertices + [0.01, -0.02, 0.03], model)
        back = decode_face(code.latent, code.residual, model, code.shift)
        assert np.abs(back - code.vertices).max() < 1e-7
        # Also from single precision, in which the residual is stored.
        stored = code.latent.astype(np.float32), code.residual.astype(np.float32)
        assert np.abs(decode_face(*stored, model, code.shift) - code.vertices).max() < 1e-6


def test_the_figures_are_those_of_the_latent_alone(model, strangers):
    code, error = encode_face(strangers[0], model), evaluate_shape(model, strangers[0][None])
    assert np.allclose(code.latent, model.encode(strangers[0]), atol=1e-9)
    figures = error.millimetres, error.percent, error.prior_rms
    np.testing.assert_allclose((code.millimetres, code.percent, code.prior_rms), figures, rtol=1e-9)


def test_a_known_latent_is_kept(model, strangers):
    latent = 0.5 * model.encode(strangers[1])
    code = encode_face(strangers[0], model, latent)
    assert np.array_equal(code.latent, latent)
    assert np.abs(decode_face(latent, code.residual, model, code.shift) - strangers[0]).max() < 1e-7


def test_a_shape_of_a_linear_model_leaves_nothing_over(pca):
    latent = pca.prior.sample(np.random.default_rng(0), 1)[0]
    code = encode_face(pca.decode(latent), pca)
    assert np.abs(code.latent - latent).max() < 1e-9
    assert np.abs(code.residual).max() < 1e-7 and np.abs(code.shift).max() < 1e-12 and code.millimetres < 1e-9


def test_it_is_the_intrinsic_models_own_decoding(intrinsic, strangers):
    code = encode_face(strangers[0], intrinsic)
    expected = intrinsic.decode(code.latent, code.residual)
    assert np.abs(decode_face(code.latent, code.residual, intrinsic) - expected).max() < 1e-12


def test_a_moved_face_differs_in_where_it_is(intrinsic, strangers):
    here, there = (encode_face(strangers[0] + shift, intrinsic) for shift in (0, np.array([0.1, 0.2, 0.3])))
    assert np.allclose(there.latent, here.latent, atol=1e-9) and np.allclose(there.residual, here.residual, atol=1e-9)
    assert np.allclose(there.shift - here.shift, [0.1, 0.2, 0.3])


def test_an_edit_of_the_latent_keeps_the_likeness(pca, strangers):
    """The residual turns along with the surface: what is beyond the latent is there after an edit as well."""
    code = encode_face(strangers[0], pca)
    change = np.zeros(len(code.latent))
    change[:5] = 1
    edited = decode_face(code.latent + change, code.residual, pca, code.shift)
    gradients = pca.template.gradients
    expected = gradients.features(pca.decode(code.latent + change)) + code.residual
    found = gradients.features(edited)
    left = np.abs(found - expected).mean() / np.abs(code.residual).mean()
    assert left < 0.2
    assert np.allclose(edited.mean(0), pca.decode(code.latent + change).mean(0) + code.shift)
