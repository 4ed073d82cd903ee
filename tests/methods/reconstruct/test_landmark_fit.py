import numpy as np

from caricli.methods.reconstruct.landmark_fit import Observation


def test_square_sums_of_whitened_values_count_the_confidence(pca, seen, strangers):
    """Also where errors along both axes go together."""
    generator = np.random.default_rng(3)
    points = seen(strangers[0]).points
    roots = 4 * generator.normal(size=(len(points), 2, 2))
    observation = Observation(points, pca.template, None, roots @ roots.swapaxes(1, 2))
    values = generator.normal(size=(len(points), 2))
    confidence = observation.confidence(0.01)
    squares = np.einsum("ka,kab,kb->k", values, confidence, values)
    np.testing.assert_allclose((observation.whitened(values, 0.01) ** 2).sum(1), squares)
    assert np.abs(confidence[:, 0, 1]).max() > 0.1 and squares.max() < (values**2).sum(1).max()
