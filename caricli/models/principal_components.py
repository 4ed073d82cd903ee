"""Principal components with the scale of one standard deviation."""

import numpy as np
from sklearn.decomposition import PCA


def principal_components(rows, dimension, seed=0):
    """Mean, components scaled to one standard deviation, and how much variance they explain.

    rows: (N, M), already weighted. dimension: D, at most min(N, M) (fewer are returned where there are fewer).
    Returns (mean (M,), components (D, M), explained (D,) fractions of the variance).
    """
    dimension = min(dimension, len(rows) - 1, rows.shape[1])
    pca = PCA(dimension, svd_solver="randomized", iterated_power=7, random_state=seed).fit(rows)
    scaled = pca.components_ * np.sqrt(pca.explained_variance_)[:, None]
    return pca.mean_, scaled, pca.explained_variance_ratio_
