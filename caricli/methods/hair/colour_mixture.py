"""Mixtures of Gaussians over colours."""

import cv2
import numpy as np

_ROUNDS = 100  # at most, of expectation and maximisation
_GAIN = 1e-2  # of the mean log-likelihood: with less a round is the last
_LIGHTEST = 1e-6  # of the samples: what a Gaussian has at least
_MIDDLE = 128.0  # is near all colours, so that no digits are lost


class ColourMixture:
    """A mixture of Gaussians, fitted by expectation and maximisation from groups of like colours (k-means++).

    A log-density is linear in products of coordinates, so that a round is two products of matrices. scikit-learn has
    such mixtures, too, but its import alone takes over a second.
    """

    def __init__(self, colours: np.ndarray, count: int, spread: float) -> None:
        """colours: (N, 3) samples, 0 to 255, at least count. count: K Gaussians. spread: added to their variances."""
        terms = _products(colours)
        cv2.setRNGSeed(0)
        stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, _ROUNDS, _GAIN)
        groups = cv2.kmeans(colours.astype(np.float32), count, None, stop, 1, cv2.KMEANS_PP_CENTERS)[1]  # type: ignore[call-overload]
        shares = np.eye(count)[groups.ravel()]
        before = -np.inf
        for _ in range(_ROUNDS):
            self.coefficients = _log_densities(shares.T @ terms / len(terms), spread)
            scores = terms @ self.coefficients
            total = _log_sum(scores)
            mean = total.mean()
            if mean - before < _GAIN:
                break
            before = mean
            shares = np.exp(scores - total[:, None])


class AskedColours:
    """Colours that mixtures are asked about, one after the other."""

    def __init__(self, colours: np.ndarray) -> None:
        """colours: (..., 3), 0 to 255."""
        self.colours = colours
        self._terms = _products(colours.reshape(-1, 3))

    def log_likelihoods(self, mixture: ColourMixture) -> np.ndarray:
        """(...) natural logarithms of the densities that a mixture has there."""
        return _log_sum(self._terms @ mixture.coefficients).reshape(self.colours.shape[:-1])


def _products(colours: np.ndarray) -> np.ndarray:
    """(N, 13): one, coordinates and all products of two of them."""
    x = colours.astype(np.float64) - _MIDDLE
    return np.column_stack([np.ones(len(x)), x, (x[:, :, None] * x[:, None]).reshape(len(x), 9)])


def _log_densities(moments: np.ndarray, spread: float) -> np.ndarray:
    """(13, K) with which products give weighted log-densities. moments: (K, 13) shares and mean products."""
    weight = np.maximum(moments[:, 0], _LIGHTEST)
    mean = moments[:, 1:4] / weight[:, None]
    covariance = (moments[:, 4:] / weight[:, None]).reshape(-1, 3, 3) - mean[:, :, None] * mean[:, None]
    precision = np.linalg.inv(covariance + spread * np.eye(3))
    linear = np.einsum("kij,kj->ki", precision, mean)
    constant = np.log(weight) - ((linear * mean).sum(1) + 3 * np.log(2 * np.pi) - np.linalg.slogdet(precision)[1]) / 2
    return np.column_stack([constant, linear, -precision.reshape(-1, 9) / 2]).T


def _log_sum(scores: np.ndarray) -> np.ndarray:
    """(N,) logarithms of sums of exponentials of scores (N, K)."""
    # A row for each Gaussian: NumPy is slow along axes of a few.
    rows = np.ascontiguousarray(scores.T)
    most: np.ndarray = rows.max(0)
    return most + np.log(np.exp(rows - most).sum(0))
