"""Principal components with the scale of one standard deviation."""

import numpy as np

from caricli.errors import NumericsError

MIN_SHARE = 1e-8
"""Of the variance: a component below it is rounding, which half precision cannot hold."""

_SAME = 1e-6
"""Rows that differ by less, relative to their largest number, are the same."""


def principal_components(rows: np.ndarray, dimension: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean, components scaled to one standard deviation, and how much variance they explain.

    rows: (N, M), already weighted. dimension: D; fewer are returned where the rows have fewer. seed: of the randomised
    decomposition.
    Returns (mean (M,), components (D, M), explained (D,) fractions of the variance).
    Raises NumericsError when all rows are the same.
    """
    # Slow to import, and only training needs it.
    from sklearn.decomposition import PCA

    if np.ptp(rows, axis=0).max() <= _SAME * np.abs(rows[0]).max():
        raise NumericsError(f"expected at least two shapes that differ, found {len(rows)} that do not")
    dimension = min(dimension, len(rows) - 1, rows.shape[1])
    pca = PCA(dimension, svd_solver="randomized", iterated_power=7, random_state=seed).fit(rows)
    scaled = pca.components_ * np.sqrt(pca.explained_variance_)[:, None]
    kept = pca.explained_variance_ratio_ > MIN_SHARE
    return pca.mean_, scaled[kept], pca.explained_variance_ratio_[kept]
