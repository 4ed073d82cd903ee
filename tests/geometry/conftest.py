"""Small meshes for the numerical core, built in code."""

import numpy as np
import pytest

from caricli.geometry.deformation.deformation_gradients import DeformationGradients


@pytest.fixture(scope="session")
def patch():
    """A curved, uneven sheet of 63 vertices with a boundary; faces counter-clockwise seen from +z."""
    rows, columns = 7, 9
    y, x = np.mgrid[:rows, :columns].astype(float)
    x, y = x + 0.15 * np.sin(3 * y + x), y + 0.15 * np.cos(2 * x - y)
    vertices = np.stack([x, y, 0.1 * (x - 4) ** 2 - 0.08 * (y - 2) ** 2 + 0.02 * x * y], axis=-1).reshape(-1, 3) / 4
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    quads = np.stack([corner, corner + 1, corner + columns + 1, corner + columns], axis=1)
    return vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)


@pytest.fixture(scope="session")
def ball_gradients(ball):
    return DeformationGradients(*ball)


@pytest.fixture(scope="session")
def patch_gradients(patch):
    return DeformationGradients(*patch)
