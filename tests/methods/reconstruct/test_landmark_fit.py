from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
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


def test_more_landmarks_than_the_model_has_are_refused_in_words(pca, seen, strangers):
    points = np.pad(seen(strangers[0]).points, ((0, 13), (0, 0)))
    few = replace(pca.template.annotation, landmarks=pca.template.annotation.landmarks[:68])
    with pytest.raises(InputError, match="^expected 68 landmarks, as the model has no others, found 81$"):
        Observation(points, replace(pca.template, annotation=few))


def test_a_method_of_no_such_name_is_refused(intrinsic, seen, strangers):
    with pytest.raises(InputError, match="expected a method of intrinsic, latent, found 'inside'"):
        fit_landmarks(seen(strangers[0]).points, intrinsic, "inside")
