import numpy as np
import pytest

from caricli.models.kernel.config import KernelConfig
from caricli.models.kernel.gaussian_process import gaussian_kernel
from caricli.models.kernel.model import KernelModel, train_process, vertex_weights, with_mirror_images
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel


@pytest.fixture(scope="module")
def bananas(ball_template):
    """(200, 300, 3) balls that are bent by a random amount: a curve in the space of shapes, not a line."""
    amounts = np.random.default_rng(3).normal(size=(200, 1))
    x, y, z = ball_template.vertices.T
    bent = y + 0.3 * (amounts * x + (amounts**3 - 3 * amounts) / 6 * (x**2 - 0.5))
    return np.stack([np.broadcast_to(x, bent.shape), bent, np.broadcast_to(z, bent.shape)], axis=-1)


def test_the_kernel_predicts_what_a_line_leaves_out(ball_template, bananas):
    straight = PcaModel.train(ball_template, bananas[:150], PcaConfig(1))
    config = KernelConfig(1, components=2, centres=40, width=1.0, near=0.0)
    curved = KernelModel.train(ball_template, bananas[:150], config)
    unseen = bananas[150:]
    errors = [np.linalg.norm(m.decode(m.encode(unseen)) - unseen, axis=-1).mean() for m in (straight, curved)]
    assert errors[1] < 0.2 * errors[0]


def test_with_as_many_components_as_dimensions_it_is_the_linear_model(ball_template, balls):
    linear = PcaModel.train(ball_template, balls, PcaConfig(5))
    kernel = KernelModel.train(ball_template, balls, KernelConfig(5, components=5, near=0.0))
    assert np.allclose(kernel.decode(kernel.encode(balls)), linear.decode(linear.encode(balls)), atol=1e-9)


def test_far_from_the_training_shapes_it_goes_on_linearly(kernel):
    far = np.full(len(kernel.prior.mean), 100.0)
    assert np.allclose(kernel.decode(far), kernel.mean + np.tensordot(far, kernel.basis[: len(far)], 1))


def test_the_mean_face_is_the_mean_of_the_shapes(kernel, people, head_template):
    everyone = with_mirror_images(people, head_template.annotation.mirror)
    assert len(everyone) == 2 * len(people)
    difference = kernel.decode(kernel.prior.mean) - everyone.mean(0)
    assert np.linalg.norm(difference, axis=1).max() < 1e-4 * head_template.height


def test_the_mirror_image_of_a_latent_s_face_has_a_latent(kernel, people, head_template):
    mirror = head_template.annotation.mirror
    for shape in people[:3]:
        image = shape[mirror] * [-1, 1, 1]
        codes = kernel.encode(np.array([shape, image]))
        assert kernel.prior.rms(codes)[1] == pytest.approx(kernel.prior.rms(codes)[0], rel=0.05)
        shapes = kernel.decode(codes)
        assert np.linalg.norm(shapes[0][mirror] * [-1, 1, 1] - shapes[1], axis=1).mean() < 2e-4


def test_shapes_without_mirror_map_are_left_alone(balls):
    assert with_mirror_images(balls, None) is balls


def test_vertices_near_landmarks_weigh_more(head_template):
    weights = vertex_weights(head_template, 3.0, 0.02)
    landmarks = head_template.annotation.landmarks
    assert np.allclose(weights[landmarks], 4)
    crown = head_template.vertices[:, 1].argmax()
    assert weights[crown] == pytest.approx(1)
    assert (vertex_weights(head_template, 0.0, 0.02) == 1).all()
    larger = head_template.with_vertices(10 * head_template.vertices)
    np.testing.assert_allclose(vertex_weights(larger, 3.0, 0.02), weights)


def test_encode_finds_the_nearest_shape(kernel, people):
    """No small step from what was found comes nearer."""
    shape = people[3] + np.random.default_rng(0).normal(0, 1e-3, people[3].shape)
    found = kernel.encode(shape)
    cost = np.square(kernel.decode(found) - shape).sum()
    for direction in np.random.default_rng(1).normal(size=(20, len(found))):
        assert np.square(kernel.decode(found + 1e-3 * direction) - shape).sum() > cost


@pytest.mark.parametrize("width", [0.25, 1.0, 3.0])
def test_centres_are_training_latents_as_far_apart_as_the_kernel_is_narrow(width):
    coefficients = np.random.default_rng(4).normal(size=(400, 9))
    config = KernelConfig(6, components=9, centres=50, width=width)
    process = train_process(coefficients, np.linspace(2, 1, 9), config)
    latents = process.centres / process.scale
    assert len(latents) == 50 and np.abs(latents[:, None] - coefficients[:, :6]).max(2).min(1).max() < 1e-9
    assert np.sqrt((process.centres**2).sum(1).mean()) == pytest.approx(1 / width, rel=0.15)
    other = train_process(coefficients, np.linspace(2, 1, 9), KernelConfig(6, 9, 50, width, seed=1))
    assert not np.array_equal(other.centres, process.centres)


def test_the_kernel_is_that_of_slow_distances_and_never_above_one():
    points = np.random.default_rng(5).normal(size=(7, 4))
    centres = np.vstack([points[:3], np.random.default_rng(6).normal(size=(5, 4))])
    slow = np.exp(-((points[:, None] - centres) ** 2).sum(-1) / 2)
    np.testing.assert_allclose(gaussian_kernel(points, centres), slow, atol=1e-12)
    far = 1e8 * (1 + np.random.default_rng(7).uniform(size=(200, 4)))
    assert gaussian_kernel(far, far).max() <= 1
