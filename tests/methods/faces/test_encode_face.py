from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.evaluate.evaluate_shape import evaluate_shape
from caricli.methods.faces.encode_face import decode_face, encode_face
from caricli.structures import Camera, Face


@pytest.fixture(params=["pca", "intrinsic"])
def model(request):
    return request.getfixturevalue(request.param)


def face_of(vertices, model, **more):
    return Face(model.template.with_vertices(vertices), **more)


def test_latent_residual_and_shift_give_the_very_face_back(model, strangers):
    for vertices in strangers[:3]:
        code = encode_face(face_of(vertices + [0.01, -0.02, 0.03], model), model)
        back = decode_face(code, model, code.shift)
        assert np.abs(back.vertices - code.vertices).max() < 1e-7
        # Also from single precision, in which the residual is stored.
        single = replace(code, latent=code.latent.astype(np.float32), residual=code.residual.astype(np.float32))
        assert np.abs(decode_face(single, model, code.shift).vertices - code.vertices).max() < 1e-6


@pytest.mark.parametrize("moved", [[0.0, 1.6, 0.0], [0.0, -0.11, -0.09]])
def test_where_another_program_put_a_head_is_no_shape(model, strangers, moved):
    code = encode_face(face_of(strangers[0], model), model)
    away = encode_face(face_of(strangers[0] + moved, model), model)
    assert away.percent < code.percent + 1 and away.prior_rms < code.prior_rms + 1
    np.testing.assert_allclose(decode_face(away, model, away.shift).vertices, strangers[0] + moved, atol=1e-6)


def test_the_figures_are_those_of_the_latent_alone(model, strangers):
    code, error = encode_face(face_of(strangers[0], model), model), evaluate_shape(model, strangers[0][None])
    assert np.allclose(code.latent, model.encode(strangers[0]), atol=1e-9)
    figures = error.millimetres, error.percent, error.prior_rms
    np.testing.assert_allclose((code.millimetres, code.percent, code.prior_rms), figures, rtol=1e-9)


def test_a_latent_of_the_model_is_kept_and_another_is_not(model, strangers):
    latent = 0.5 * model.encode(strangers[1])
    code = encode_face(face_of(strangers[0], model, latent=latent, model_id=model.model_id), model)
    assert np.array_equal(code.latent, latent) and code.model_id == model.model_id
    assert np.abs(decode_face(code, model, code.shift).vertices - strangers[0]).max() < 1e-7
    foreign = encode_face(face_of(strangers[0], model, latent=latent, residual=code.residual, model_id="other"), model)
    assert np.array_equal(foreign.latent, encode_face(face_of(strangers[0], model), model).latent)
    assert foreign.model_id == model.model_id and foreign.residual is not code.residual


def test_a_residual_is_kept_where_it_gives_the_face(model, strangers):
    code = encode_face(face_of(strangers[0], model), model)
    assert encode_face(code, model).residual is code.residual
    moved = replace(code, mesh=code.mesh.with_vertices(strangers[1]))
    again = encode_face(moved, model)
    assert np.array_equal(again.latent, code.latent) and again.residual is not code.residual
    assert np.abs(decode_face(again, model, again.shift).vertices - strangers[1]).max() < 1e-7


def test_mesh_camera_and_landmarks_stay(pca, strangers):
    camera, landmarks = Camera(900.0, np.diag([1.0, -1, -1]), np.ones(2)), np.arange(136.0).reshape(68, 2)
    code = encode_face(face_of(strangers[0], pca, camera=camera, landmarks=landmarks), pca)
    back = decode_face(code, pca, code.shift)
    for face in (code, back):
        assert face.camera is camera and face.landmarks is landmarks
        assert face.mesh.polygons is pca.template.polygons


def test_a_shape_of_a_linear_model_leaves_nothing_over(pca):
    latent = pca.prior.sample(np.random.default_rng(0), 1)[0]
    code = encode_face(face_of(pca.decode(latent), pca), pca)
    assert np.abs(code.latent - latent).max() < 1e-9
    assert np.abs(code.residual).max() < 1e-7 and np.abs(code.shift).max() < 1e-12 and code.millimetres < 1e-9


def test_it_is_the_intrinsic_models_own_decoding(intrinsic, strangers):
    code = encode_face(face_of(strangers[0], intrinsic), intrinsic)
    expected = intrinsic.decode(code.latent, code.residual)
    assert np.abs(decode_face(code, intrinsic).vertices - expected).max() < 1e-12


def test_a_moved_face_differs_in_where_it_is(intrinsic, strangers):
    shifts = (0, np.array([0.1, 0.2, 0.3]))
    here, there = (encode_face(face_of(strangers[0] + shift, intrinsic), intrinsic) for shift in shifts)
    assert np.allclose(there.latent, here.latent, atol=1e-9) and np.allclose(there.residual, here.residual, atol=1e-9)
    assert np.allclose(there.shift - here.shift, [0.1, 0.2, 0.3])


def test_an_edit_of_the_latent_keeps_the_likeness(pca, strangers):
    """The residual turns along with the surface: what is beyond the latent is there after an edit as well."""
    code = encode_face(face_of(strangers[0], pca), pca)
    change = np.zeros(len(code.latent))
    change[:5] = 1
    edited = decode_face(replace(code, latent=code.latent + change), pca, code.shift)
    gradients = pca.template.gradients
    expected = gradients.features(pca.decode(edited.latent)) + code.residual
    left = np.abs(gradients.features(edited.vertices) - expected).mean() / np.abs(code.residual).mean()
    assert left < 0.2
    assert np.allclose(edited.vertices.mean(0), pca.decode(edited.latent).mean(0) + code.shift)
