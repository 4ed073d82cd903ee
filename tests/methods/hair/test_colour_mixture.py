import numpy as np
from scipy.stats import multivariate_normal

from caricli.methods.hair.colour_mixture import AskedColours, ColourMixture


def test_two_colours_are_told_apart_by_their_densities():
    generator = np.random.default_rng(0)
    dark = generator.multivariate_normal([40, 120, 130], np.diag([25.0, 9, 9]), 600)
    light = generator.multivariate_normal([200, 140, 110], np.diag([9.0, 25, 9]), 200)
    mixture = ColourMixture(np.concatenate([dark, light]), 2, 0.0)
    asked = np.array([[[40, 120, 130], [200, 140, 110]], [[45, 118, 131], [120, 130, 120]]], float)
    groups = [(0.75, dark), (0.25, light)]
    # Of the samples themselves: nothing else is told to the mixture.
    density = sum(share * multivariate_normal(g.mean(0), np.cov(g.T, bias=True)).pdf(asked) for share, g in groups)
    np.testing.assert_allclose(AskedColours(asked).log_likelihoods(mixture), np.log(density), atol=1e-5)


def test_spread_is_what_one_colour_has():
    mixture = ColourMixture(np.full((60, 3), 90.0), 2, 4.0)
    expected = multivariate_normal([90] * 3, 4 * np.eye(3)).logpdf([92, 90, 90])
    np.testing.assert_allclose(AskedColours(np.array([92.0, 90, 90])).log_likelihoods(mixture), expected, atol=1e-4)
