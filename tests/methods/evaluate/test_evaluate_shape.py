import numpy as np
import pytest

from caricli.methods.evaluate.evaluate_shape import evaluate_shape
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel


@pytest.fixture(scope="module")
def model(head_template, people):
    return PcaModel.train(head_template, people[:30], PcaConfig(29))


def test_training_shapes_are_held_exactly_by_all_components(model, people):
    error = evaluate_shape(model, people[:30])
    assert error.meshes == 30
    assert error.millimetres < 1e-6 and error.percent < 1e-6
    # 29 dimensions of 30 centred shapes: the whitened latents have unit variance.
    assert 0.9 < error.prior_rms < 1.1


def test_the_error_is_the_mean_distance(model, people):
    shapes = people[30:]
    distances = np.linalg.norm(model.decode(model.encode(shapes)) - shapes, axis=-1)
    error = evaluate_shape(model, shapes)
    np.testing.assert_allclose(error.millimetres, 1000 * distances.mean())
    np.testing.assert_allclose(error.percent, 0.1 * error.millimetres / model.template.height)
    assert error.millimetres > 0.01


def test_many_batches_are_as_good_as_one(model, people):
    whole = evaluate_shape(model, people)
    parts = [evaluate_shape(model, shape[None]) for shape in people]
    np.testing.assert_allclose(whole.millimetres, np.mean([part.millimetres for part in parts]))
    np.testing.assert_allclose(whole.prior_rms, np.mean([part.prior_rms for part in parts]))


def test_no_shapes_have_no_error(model, people):
    assert evaluate_shape(model, people[:0]) is None
