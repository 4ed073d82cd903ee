import numpy as np

from caricli.geometry.lines.along_lines import along


def test_along_agrees_with_interpolation_by_length():
    generator = np.random.default_rng(0)
    lines = generator.normal(size=(4, 7, 3))
    shares = generator.uniform(0, 1, (4, 11))
    for line, asked, found in zip(lines, shares, along(lines, shares), strict=True):
        reached = np.append(0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
        expected = np.stack([np.interp(asked * reached[-1], reached, line[:, k]) for k in range(3)], 1)
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_along_goes_on_beyond_both_ends():
    line = np.array([[[0.0, 0], [1, 0], [1, 3]]])
    np.testing.assert_allclose(along(line, np.array([[-0.5, 1.5]])), [[[-2, 0], [1, 5]]], atol=1e-12)
    np.testing.assert_array_equal(along(np.zeros((1, 3, 2)), np.array([[0.0, 1]])), np.zeros((1, 2, 2)))
