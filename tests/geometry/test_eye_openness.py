import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.eye_openness import eye_openness


def test_openness_is_height_for_width_in_any_size_and_turn():
    ring = np.array([[0.0, 0, 0], [1, 0.5, 0], [2, 0.7, 0], [3, 0, 0], [2, -0.5, 0], [1, -0.3, 0]])
    assert eye_openness(ring) == eye_openness(ring[:, :2]) == pytest.approx((0.8 + 1.2) / 2 / 3)
    assert eye_openness(5 * ring @ head_rotation(np.array([0.3, -0.5, 0.2])).T + 7) == pytest.approx(eye_openness(ring))
    assert eye_openness(ring * [1, 0, 1]) == 0 and np.isfinite(eye_openness(np.zeros((6, 2))))
