import cv2
import numpy as np
import pytest

from caricli.render.pixels.sample_texture import sample_pixels, sample_texture, texture_matrix


def bilinear(image, x, y):
    """Slowly, in double precision, the outermost pixels go on."""
    height, width = image.shape[:2]
    result = []
    for u, v in zip(np.clip(x, 0, width - 1), np.clip(y, 0, height - 1), strict=True):
        a, b = min(int(u), width - 2), min(int(v), height - 2)
        s, t = u - a, v - b
        rows = [(1 - s) * image[r, a] + s * image[r, a + 1] for r in (b, b + 1)]
        result.append((1 - t) * rows[0] + t * rows[1])
    return np.array(result)


@pytest.mark.parametrize("shape", [(9, 12), (9, 12, 3)])
def test_samples_are_bilinear_and_the_border_goes_on(shape):
    generator = np.random.default_rng(0)
    image = generator.uniform(0, 1, shape).astype(np.float32)
    x, y = generator.uniform(-3, 15, (2, 200))
    found = sample_pixels(image, x, y)
    assert found.shape == (200, *shape[2:])
    # OpenCV knows 32 places between two pixels.
    np.testing.assert_allclose(found, bilinear(image.astype(float), x, y), atol=0.04)
    rows, columns = np.mgrid[:9, :12]
    np.testing.assert_allclose(sample_pixels(image, columns.ravel(), rows.ravel()), image.reshape(-1, *shape[2:]))


def test_outside_may_have_its_own_value():
    image = np.ones((4, 4), np.float32)
    assert sample_pixels(image, [-5, 1, 9], [1, 1, 1], border=0.0).tolist() == [0, 1, 0]
    depth = np.array([[1.0, np.inf]], np.float32)
    found = sample_pixels(depth, [0, 0.4, 1, 7], [0, 0, 0, 0], cv2.INTER_NEAREST, float("inf"))
    assert found.tolist() == [1, 1, np.inf, np.inf]


@pytest.mark.parametrize("count", [0, 1, 4096, 4097, 40_001, 150_000])
def test_any_number_of_places(count):
    image = np.arange(50, dtype=np.float32).reshape(5, 10)
    places = np.random.default_rng(count).integers(0, 50, count)
    np.testing.assert_array_equal(sample_pixels(image, places % 10, places // 10), image.ravel()[places])


def test_uvs_start_at_the_bottom_left():
    texture = np.zeros((4, 8, 3), np.uint8)
    texture[3, 0], texture[0, 7] = 200, 100
    corner = np.array([0.5 / 8, 0.5 / 4])
    found = sample_texture(texture, np.array([corner, 1 - corner, [0, 0], [1, 1], [0.5, 0.5]]))
    assert found[:, 0].tolist() == [200, 100, 200, 100, 0] and found.shape == (5, 3)


def test_the_matrix_takes_the_samples():
    generator = np.random.default_rng(2)
    colours, owner = generator.uniform(0, 255, (5, 3)), generator.integers(0, 5, (6, 9))
    uvs = generator.uniform(-0.2, 1.2, (300, 2))
    matrix = texture_matrix(owner, 5, uvs)
    assert matrix.shape == (300, 5) and matrix.min() >= 0
    np.testing.assert_allclose(matrix.sum(1), 1, rtol=1e-6)
    # OpenCV knows 32 places between two pixels.
    wanted = sample_texture(colours[owner].astype(np.float32), uvs)
    np.testing.assert_allclose(matrix @ colours, wanted, atol=0.04 * 255)
    corners = texture_matrix(np.arange(12).reshape(3, 4), 12, np.array([[0.5 / 4, 0.5 / 3], [3.5 / 4, 2.5 / 3]]))
    np.testing.assert_allclose(corners.toarray(), np.eye(12)[[8, 3]], atol=1e-12)
