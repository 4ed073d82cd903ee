import numpy as np

from caricli.methods.nearest_identity import nearest_identity


def test_the_nearest_neutral_is_found():
    neutrals = np.random.default_rng(0).normal(size=(7, 5))
    owners = np.array([3, 0, 6, 3])
    assert nearest_identity(neutrals[owners] + 0.01, neutrals).tolist() == owners.tolist()
    # Not the direction counts but the place.
    assert nearest_identity(np.array([[4.0, 0.0]]), np.array([[1.0, 0.0], [4.0, 2.0]])).tolist() == [1]
