"""Colours of pictures at places of them."""

import cv2
import numpy as np
import scipy.sparse as sp

_WIDTH = 4096  # places in a row: OpenCV takes no more than 32,767 rows or columns


def sample_pixels(
    image: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    interpolation: int = cv2.INTER_LINEAR,
    border: float | None = None,
) -> np.ndarray:
    """Sample a picture at pixels; the centre of the top-left one is (0, 0).

    image: (H, W) or (H, W, C). x, y: (N,). interpolation: of OpenCV. border: value outside the picture; where there is
    none, its outermost pixels go on.
    Returns (N,) or (N, C).
    """
    rows = max(-(-len(x) // _WIDTH), 1)
    columns, lines = (np.resize(np.asarray(a, np.float32), (rows, _WIDTH)) for a in (x, y))
    mode = cv2.BORDER_REPLICATE if border is None else cv2.BORDER_CONSTANT
    samples = cv2.remap(image, columns, lines, interpolation, borderMode=mode, borderValue=border or 0)
    return samples.reshape(-1, *image.shape[2:])[: len(x)]


def uv_pixels(uvs: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """(..., 2) where UVs (..., 2) are in a picture of H and W texels, the centre of the top-left one at (0, 0)."""
    height, width = size
    return np.stack([uvs[..., 0] * width - 0.5, (1 - uvs[..., 1]) * height - 0.5], axis=-1)


def sample_texture(texture: np.ndarray, uvs: np.ndarray) -> np.ndarray:
    """Bilinear samples (N, C). texture: (H, W, C) uint8, the top row first. uvs: (N, 2), origin bottom left."""
    places = uv_pixels(uvs, texture.shape[:2])
    return sample_pixels(texture, places[:, 0], places[:, 1]).astype(np.float64)


def texture_matrix(owner: np.ndarray, count: int, uvs: np.ndarray) -> sp.csr_matrix:
    """What bilinear samples take of every colour, where texels share colours.

    owner: (H, W) int, the colour that a texel has, of ``count``. uvs: (N, 2).
    Returns (N, count), sparse, float32; a colour that several texels of a sample have is there as often.
    """
    height, width = owner.shape
    places = uv_pixels(uvs, owner.shape)
    first = np.floor(places).astype(int)
    rest = (places - first).astype(np.float32)
    owners = np.empty((len(uvs), 4), np.int32)
    parts = np.empty((len(uvs), 4), np.float32)
    for corner, (right, down) in enumerate(np.ndindex(2, 2)):
        column = np.clip(first[:, 0] + right, 0, width - 1)
        row = np.clip(first[:, 1] + down, 0, height - 1)
        owners[:, corner] = owner[row, column]
        parts[:, corner] = np.abs(1 - right - rest[:, 0]) * np.abs(1 - down - rest[:, 1])
    ends = np.arange(0, owners.size + 1, 4)
    return sp.csr_matrix((parts.ravel(), owners.ravel(), ends), (len(uvs), count))
