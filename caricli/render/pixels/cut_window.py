"""A window of a picture, at any scale and turn."""

import numpy as np

_COARSEST = 0.75
"""Pixels of the window a pixel of the picture, below which the picture is made smaller before."""


def cut_window(image: np.ndarray, matrix: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Cut a window out of a picture; beyond its edges the picture goes on as it ends.

    image: (H, W, 3) uint8. matrix: (2, 3) affine map from the picture's pixels to the window's. size: (width, height).
    Returns (height, width, 3) uint8. Where the window is smaller than its part of the picture, pixels are means.
    """
    import cv2

    scale = float(np.sqrt(abs(np.linalg.det(matrix[:, :2]))))
    if scale < _COARSEST:
        image, to_smaller = _smaller(image, matrix, size, scale)
        matrix = matrix @ to_smaller
    return cv2.warpAffine(image, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _smaller(
    image: np.ndarray, matrix: np.ndarray, size: tuple[int, int], scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """What the window shows of a picture, scaled, and the (3, 3) map from its pixels to the picture's."""
    import cv2

    corners = np.array([[0, 0], [size[0], 0], [size[0], size[1]], [0, size[1]]]) - matrix[:, 2]
    there = np.linalg.solve(matrix[:, :2], corners.T).T
    limits = np.array([image.shape[1], image.shape[0]])
    low = np.clip(np.floor(there.min(0)) - 2 / scale, 0, limits - 1).astype(int)
    high = np.clip(np.ceil(there.max(0)) + 2 / scale, low + 1, limits).astype(int)
    part = image[low[1] : high[1], low[0] : high[0]]
    smaller = np.maximum(1, np.rint((high - low) * scale)).astype(int)
    small = cv2.resize(part, smaller.tolist(), interpolation=cv2.INTER_AREA)
    step = (high - low) / smaller
    return small, np.array(
        [[step[0], 0, low[0] + step[0] / 2 - 0.5], [0, step[1], low[1] + step[1] / 2 - 0.5], [0, 0, 1]]
    )
